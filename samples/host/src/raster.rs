//! The G-buffer's pipeline, the meshes' buffers and the instances to draw.

use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::scene::{Instance, Mesh, Scene, face_normal};
use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use std::borrow::Cow;
use std::mem::offset_of;
use std::ops::Range;
use std::sync::Arc;
use wgpu_hal::{CommandEncoder as _, Device as _, vulkan as hal};
use wgpu_types as wgt;

/// Formats of the colour attachments, in the order of the shader's outputs.
pub(crate) const COLOR_FORMATS: [wgt::TextureFormat; 4] = {
    let wide = wgt::TextureFormat::Rgba16Float;
    [wide, wide, wide, wgt::TextureFormat::Rg16Float]
};
/// Format of the depth attachment.
pub(crate) const DEPTH_FORMAT: wgt::TextureFormat = wgt::TextureFormat::Depth32Float;
/// Size of the shader's `View` in bytes.
pub(crate) const VIEW_BYTES: u32 = 128;

/// In object space.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
    uv: [f32; 2],
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct InstanceEntry {
    linear: [[f32; 3]; 3],
    translation: [f32; 3],
    past_linear: [[f32; 3]; 3],
    past_translation: [f32; 3],
    material: u32,
}

/// The instances of one mesh.
pub(crate) struct Draw {
    pub(crate) vertices: Range<u32>,
    pub(crate) instances: Range<u32>,
}

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct MaterialEntry {
    base_color: [f32; 3],
    first_texel: u32,
    emission: [f32; 3],
    texture_size: u32,
}

/// Everything that a G-buffer draw binds. `Option`s are empty only while dropping.
pub(crate) struct Raster {
    gpu: Arc<Gpu>,
    /// Vertices, materials, texels.
    buffers: Vec<hal::Buffer>,
    /// By mesh, its part of the vertices.
    meshes: Vec<Range<u32>>,
    draws: Vec<Draw>,
    instances: Option<hal::Buffer>,
    /// Earlier instances, each with the last frame that may draw them.
    retired: Vec<(u64, hal::Buffer)>,
    group_layout: Option<hal::BindGroupLayout>,
    group: Option<hal::BindGroup>,
    layout: Option<hal::PipelineLayout>,
    shader: Option<hal::ShaderModule>,
    /// Of the G-buffer, and of depth alone.
    pipelines: Vec<hal::RenderPipeline>,
}

impl Raster {
    /// Draws nothing until [`Self::place`].
    pub(crate) fn new(gpu: &Arc<Gpu>, scene: &Scene) -> Result<Self> {
        let mut raster = Self {
            gpu: gpu.clone(),
            buffers: Vec::new(),
            meshes: Vec::new(),
            draws: Vec::new(),
            instances: None,
            retired: Vec::new(),
            group_layout: None,
            group: None,
            layout: None,
            shader: None,
            pipelines: Vec::new(),
        };
        raster.upload(scene)?;
        raster.make_group()?;
        raster.compile()?;
        Ok(raster)
    }

    /// Replaces the instances drawn, each as it is and as it was in the last frame; `frame` is the number of the latest
    /// frame submitted.
    pub(crate) fn place<'a>(
        &mut self,
        instances: impl IntoIterator<Item = (&'a Instance, &'a Instance)>,
        frame: u64,
    ) -> Result<()> {
        let mut instances: Vec<(&Instance, &Instance)> = instances.into_iter().collect();
        instances.sort_by_key(|(instance, _)| instance.mesh);
        let translation = |instance: &Instance| DVec3::from(instance.translation).as_vec3().to_array();
        let entry = |(instance, past): &(&Instance, &Instance)| InstanceEntry {
            linear: instance.linear,
            translation: translation(instance),
            past_linear: past.linear,
            past_translation: translation(past),
            material: instance.material as u32,
        };
        let entries: Vec<InstanceEntry> = instances.iter().map(entry).collect();
        let bytes = bytemuck::cast_slice(&entries);
        let buffer = self.gpu.filled_buffer("instances", wgt::BufferUses::VERTEX, bytes)?;
        self.retired.extend(self.instances.replace(buffer).map(|old| (frame, old)));
        self.draws.clear();
        let mut first = 0;
        for same in instances.chunk_by(|a, b| a.0.mesh == b.0.mesh) {
            let end = first + same.len() as u32;
            self.draws.push(Draw { vertices: self.meshes[same[0].0.mesh].clone(), instances: first..end });
            first = end;
        }
        Ok(())
    }

    /// Frees what only frames up to `finished` drew; the GPU has finished those.
    pub(crate) fn collect(&mut self, finished: u64) {
        for (_, buffer) in self.retired.extract_if(.., |(frame, _)| *frame <= finished) {
            // SAFETY: the GPU has finished every frame that drew from it.
            unsafe { self.gpu.device.destroy_buffer(buffer) };
        }
    }

    /// Binds everything but the pipeline.
    ///
    /// # Safety
    /// `encoder` is recording a pass, which is over before anything of this is dropped.
    pub(crate) unsafe fn bind(&self, encoder: &mut hal::CommandEncoder) {
        let whole = |buffer| wgpu_hal::BufferBinding::new_unchecked(buffer, 0, None);
        // SAFETY: by the caller.
        unsafe {
            encoder.set_bind_group(self.layout(), 0, self.group.as_ref().expect("present since creation"), &[]);
            encoder.set_vertex_buffer(0, whole(&self.buffers[0]));
            encoder.set_vertex_buffer(1, whole(self.instances.as_ref().expect("placed since creation")));
        }
    }

    pub(crate) fn draws(&self) -> &[Draw] {
        &self.draws
    }

    pub(crate) fn layout(&self) -> &hal::PipelineLayout {
        self.layout.as_ref().expect("present since creation")
    }

    pub(crate) fn pipeline(&self) -> &hal::RenderPipeline {
        &self.pipelines[0]
    }

    /// Draws depth alone.
    pub(crate) fn depth_pipeline(&self) -> &hal::RenderPipeline {
        &self.pipelines[1]
    }

    fn upload(&mut self, scene: &Scene) -> Result<()> {
        let (materials, texels) = material_table(scene);
        let storage = wgt::BufferUses::STORAGE_READ_ONLY;
        let mut vertices = Vec::new();
        for mesh in &scene.meshes {
            let first = vertices.len() as u32;
            vertices.extend(mesh.indices.chunks_exact(3).filter_map(|corners| triangle(mesh, corners)).flatten());
            self.meshes.push(first..vertices.len() as u32);
        }
        let vertex_bytes = bytemuck::cast_slice(&vertices);
        self.buffers.push(self.gpu.filled_buffer("vertices", wgt::BufferUses::VERTEX, vertex_bytes)?);
        self.buffers.push(self.gpu.filled_buffer("materials", storage, bytemuck::cast_slice(&materials))?);
        self.buffers.push(self.gpu.filled_buffer("texels", storage, &texels)?);
        Ok(())
    }

    fn make_group(&mut self) -> Result<()> {
        let entry = |binding| wgt::BindGroupLayoutEntry {
            binding,
            visibility: wgt::ShaderStages::FRAGMENT,
            ty: wgt::BindingType::Buffer {
                ty: wgt::BufferBindingType::Storage { read_only: true },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let layout = wgpu_hal::BindGroupLayoutDescriptor {
            label: Some("scene"),
            flags: wgpu_hal::BindGroupLayoutFlags::empty(),
            entries: &[entry(0), entry(1)],
        };
        // SAFETY: the entries match the shader's bindings.
        let layout = unsafe { self.gpu.device.create_bind_group_layout(&layout) };
        let layout = &*self.group_layout.insert(layout.map_err(Error::gpu("creating a bind group layout"))?);
        let binding = |binding| wgpu_hal::BindGroupEntry { binding, resource_index: binding, count: 1 };
        let whole = |buffer| wgpu_hal::BufferBinding::new_unchecked(buffer, 0, None);
        let group = wgpu_hal::BindGroupDescriptor {
            label: Some("scene"),
            layout,
            buffers: &[whole(&self.buffers[1]), whole(&self.buffers[2])],
            samplers: &[],
            textures: &[],
            entries: &[binding(0), binding(1)],
            acceleration_structures: &[],
            external_textures: &[],
        };
        // SAFETY: the buffers live as long as the group.
        let created = unsafe { self.gpu.device.create_bind_group(&group) };
        self.group = Some(created.map_err(Error::gpu("creating a bind group"))?);
        Ok(())
    }

    fn compile(&mut self) -> Result<()> {
        let description = wgpu_hal::ShaderModuleDescriptor {
            label: Some("gbuffer"),
            runtime_checks: wgt::ShaderRuntimeChecks::checked(),
        };
        // SAFETY: the module was validated by naga.
        let shader = unsafe { self.gpu.device.create_shader_module(&description, shader_input()?) };
        let shader = &*self.shader.insert(shader.map_err(Error::gpu("creating a shader module"))?);
        let layout = wgpu_hal::PipelineLayoutDescriptor {
            label: Some("gbuffer"),
            flags: wgpu_hal::PipelineLayoutFlags::empty(),
            bind_group_layouts: &[self.group_layout.as_ref()],
            immediate_size: VIEW_BYTES,
        };
        // SAFETY: 128 bytes of push constants are within every device's limit.
        let layout = unsafe { self.gpu.device.create_pipeline_layout(&layout) };
        let layout = &*self.layout.insert(layout.map_err(Error::gpu("creating a pipeline layout"))?);
        for fragments in [true, false] {
            self.pipelines.push(create_pipeline(&self.gpu, layout, shader, fragments)?);
        }
        Ok(())
    }
}

impl Drop for Raster {
    fn drop(&mut self) {
        let device = &self.gpu.device;
        // SAFETY: the host waits for the queue before it drops this; children go before parents.
        unsafe {
            self.pipelines.drain(..).for_each(|p| device.destroy_render_pipeline(p));
            self.layout.take().into_iter().for_each(|l| device.destroy_pipeline_layout(l));
            self.shader.take().into_iter().for_each(|s| device.destroy_shader_module(s));
            self.group.take().into_iter().for_each(|g| device.destroy_bind_group(g));
            self.group_layout.take().into_iter().for_each(|l| device.destroy_bind_group_layout(l));
            let retired = self.retired.drain(..).map(|(_, buffer)| buffer);
            self.buffers.drain(..).chain(self.instances.take()).chain(retired).for_each(|b| device.destroy_buffer(b));
        }
    }
}

/// `None` for a triangle without an area.
fn triangle(mesh: &Mesh, corners: &[u32]) -> Option<[Vertex; 3]> {
    let corners: [usize; 3] = std::array::from_fn(|i| corners[i] as usize);
    let normal = face_normal(corners.map(|i| Vec3::from(mesh.positions[i]).as_dvec3()))?.as_vec3().to_array();
    let uv = |i| mesh.uvs.get(i).copied().unwrap_or_default();
    Some(corners.map(|i| Vertex { position: mesh.positions[i], normal, uv: uv(i) }))
}

/// The materials, and the texels of all textures in a row.
fn material_table(scene: &Scene) -> (Vec<MaterialEntry>, Vec<u8>) {
    let mut texels = Vec::new();
    let mut firsts = Vec::new();
    for texture in &scene.textures {
        firsts.push(texels.len() as u32 / 4);
        texels.extend_from_slice(&texture.rgba8);
    }
    let size = |t: usize| scene.textures[t].width | scene.textures[t].height << 16;
    let entry = |m: &crate::scene::Material| MaterialEntry {
        base_color: m.base_color,
        first_texel: m.texture.map_or(0, |t| firsts[t]),
        emission: m.emission,
        texture_size: m.texture.map_or(0, size),
    };
    (scene.materials.iter().map(entry).collect(), texels)
}

fn shader_input() -> Result<wgpu_hal::ShaderInput<'static>> {
    let module = naga::front::wgsl::parse_str(include_str!("gbuffer.wgsl")).map_err(Error::gpu("parsing WGSL"))?;
    let mut validator =
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::IMMEDIATES);
    let info = validator.validate(&module).map_err(Error::gpu("validating WGSL"))?;
    Ok(wgpu_hal::ShaderInput::Naga(wgpu_hal::NagaShader { module: Cow::Owned(module), info, debug_source: None }))
}

/// The fields of [`Vertex`] in order, at locations 0 to 2.
fn vertex_attributes() -> [wgt::VertexAttribute; 3] {
    use wgt::VertexFormat::{Float32x2, Float32x3};
    let offsets = [offset_of!(Vertex, position), offset_of!(Vertex, normal), offset_of!(Vertex, uv)];
    attributes(0, offsets, [Float32x3, Float32x3, Float32x2])
}

/// The columns, now and in the last frame, and the material of [`InstanceEntry`] in order, at locations 3 to 11.
fn instance_attributes() -> [wgt::VertexAttribute; 9] {
    use wgt::VertexFormat::{Float32x3, Uint32};
    let column = size_of::<[f32; 3]>();
    let columns = std::array::from_fn::<_, 8, _>(|index| offset_of!(InstanceEntry, linear) + index * column);
    let [a, b, c, d, e, f, g, h] = columns;
    let formats = [Float32x3, Float32x3, Float32x3, Float32x3, Float32x3, Float32x3, Float32x3, Float32x3, Uint32];
    attributes(3, [a, b, c, d, e, f, g, h, offset_of!(InstanceEntry, material)], formats)
}

fn attributes<const N: usize>(
    first: u32,
    offsets: [usize; N],
    formats: [wgt::VertexFormat; N],
) -> [wgt::VertexAttribute; N] {
    std::array::from_fn(|i| wgt::VertexAttribute {
        format: formats[i],
        offset: offsets[i] as u64,
        shader_location: first + i as u32,
    })
}

fn create_pipeline(
    gpu: &Gpu,
    layout: &hal::PipelineLayout,
    shader: &hal::ShaderModule,
    fragments: bool,
) -> Result<hal::RenderPipeline> {
    let (vertex_attributes, instance_attributes) = (vertex_attributes(), instance_attributes());
    let constants = naga::back::PipelineConstants::default();
    let stage = |entry_point| wgpu_hal::ProgrammableStage {
        module: shader,
        entry_point,
        constants: &constants,
        zero_initialize_workgroup_memory: false,
    };
    let color = |format| Some(wgt::ColorTargetState { format, blend: None, write_mask: wgt::ColorWrites::ALL });
    let colors = COLOR_FORMATS.map(color);
    let description = wgpu_hal::RenderPipelineDescriptor {
        label: Some("gbuffer"),
        layout,
        vertex_processor: wgpu_hal::VertexProcessor::Standard {
            vertex_buffers: &[
                Some(wgpu_hal::VertexBufferLayout {
                    array_stride: size_of::<Vertex>() as u64,
                    step_mode: wgt::VertexStepMode::Vertex,
                    attributes: &vertex_attributes,
                }),
                Some(wgpu_hal::VertexBufferLayout {
                    array_stride: size_of::<InstanceEntry>() as u64,
                    step_mode: wgt::VertexStepMode::Instance,
                    attributes: &instance_attributes,
                }),
            ],
            vertex_stage: stage("corner"),
        },
        primitive: wgt::PrimitiveState::default(),
        depth_stencil: Some(wgt::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgt::CompareFunction::Greater),
            stencil: wgt::StencilState::default(),
            bias: wgt::DepthBiasState::default(),
        }),
        multisample: wgt::MultisampleState::default(),
        fragment_stage: fragments.then(|| stage("surface")),
        color_targets: if fragments { &colors } else { &[] },
        multiview_mask: None,
        cache: None,
    };
    // SAFETY: layout, vertex attributes and outputs match the shader.
    unsafe { gpu.device.create_render_pipeline(&description) }.map_err(Error::gpu("creating the G-buffer pipeline"))
}
