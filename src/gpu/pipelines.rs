//! One compute pipeline for each shader.

use super::Device;
use super::shaders::{BindingKind, SHADERS, Shader};
use crate::error::{Error, Result};
use ash::vk;
use rustc_hash::FxHashMap;

/// A shader's pipeline and layouts.
pub struct Pipeline {
    pub shader: &'static Shader,
    pub raw: vk::Pipeline,
    pub layout: vk::PipelineLayout,
    pub set_layout: vk::DescriptorSetLayout,
}

/// Passes of which a host needs few, or none, and whose pipelines are made when it asks for them: by how these begin.
const ON_DEMAND: [&str; 6] = ["composite", "debug_view", "disocclusion", "light_bounce", "light_direct", "resolve"];

/// All pipelines, by pass.
pub struct Pipelines {
    by_name: FxHashMap<&'static str, Pipeline>,
}

pub fn descriptor_type(kind: BindingKind) -> vk::DescriptorType {
    match kind {
        BindingKind::Uniform => vk::DescriptorType::UNIFORM_BUFFER,
        BindingKind::Storage => vk::DescriptorType::STORAGE_BUFFER,
        BindingKind::SampledImage => vk::DescriptorType::SAMPLED_IMAGE,
        BindingKind::StorageImage => vk::DescriptorType::STORAGE_IMAGE,
    }
}

impl Pipelines {
    /// Creates all of them but those that [`Pipelines::add`] is for.
    pub fn new(device: &Device) -> Result<Self> {
        Self::of(device, SHADERS.iter().filter(|shader| !ON_DEMAND.iter().any(|pass| shader.name.starts_with(pass))))
    }

    /// Creates a pass's pipeline, unless there is one.
    pub fn add(&mut self, device: &Device, pass: &str) -> Result<()> {
        if !self.by_name.contains_key(pass) {
            let mut more = Self::of(device, SHADERS.iter().filter(|shader| shader.name == pass))?;
            self.by_name.extend(more.by_name.drain());
        }
        Ok(())
    }

    /// Creates those of the given shaders.
    pub fn of(device: &Device, shaders: impl IntoIterator<Item = &'static Shader>) -> Result<Self> {
        let mut all = Self { by_name: FxHashMap::default() };
        for shader in shaders {
            let mut pipeline = Pipeline {
                shader,
                raw: vk::Pipeline::null(),
                layout: vk::PipelineLayout::null(),
                set_layout: vk::DescriptorSetLayout::null(),
            };
            let made = pipeline.create(device);
            all.by_name.insert(shader.name, pipeline);
            if let Err(error) = made {
                all.destroy(device);
                return Err(error);
            }
        }
        Ok(all)
    }

    /// The pipeline of a pass. Names come from the same table as the pipelines.
    pub fn get(&self, pass: &str) -> &Pipeline {
        &self.by_name[pass]
    }

    /// Destroys all; the GPU must have finished with them.
    pub fn destroy(&mut self, device: &Device) {
        for (_, p) in self.by_name.drain() {
            // SAFETY: made on this device, no longer in use; null handles are ignored.
            unsafe {
                device.raw.destroy_pipeline(p.raw, None);
                device.raw.destroy_pipeline_layout(p.layout, None);
                device.raw.destroy_descriptor_set_layout(p.set_layout, None);
            }
        }
    }
}

impl Pipeline {
    fn create(&mut self, device: &Device) -> Result<()> {
        let raw = &device.raw;
        let bindings: Vec<_> = self
            .shader
            .bindings
            .iter()
            .map(|b| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(b.slot)
                    .descriptor_type(descriptor_type(b.kind))
                    .descriptor_count(1)
                    .stage_flags(vk::ShaderStageFlags::COMPUTE)
            })
            .collect();
        let set_info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        // SAFETY (all calls below): valid device, and create infos whose pointers live until the call returns.
        self.set_layout = unsafe { raw.create_descriptor_set_layout(&set_info, None) }
            .map_err(Error::vulkan("vkCreateDescriptorSetLayout"))?;
        let sets = [self.set_layout];
        let push = [vk::PushConstantRange {
            stage_flags: vk::ShaderStageFlags::COMPUTE,
            offset: 0,
            size: self.shader.push_bytes.max(4),
        }];
        let mut layout_info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets);
        if self.shader.push_bytes > 0 {
            layout_info = layout_info.push_constant_ranges(&push);
        }
        // SAFETY: see above.
        self.layout = unsafe { raw.create_pipeline_layout(&layout_info, None) }
            .map_err(Error::vulkan("vkCreatePipelineLayout"))?;
        let words = self.shader.spirv.words();
        let module_info = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: see above; the SPIR-V was validated when it was built.
        let module =
            unsafe { raw.create_shader_module(&module_info, None) }.map_err(Error::vulkan("vkCreateShaderModule"))?;
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module)
            .name(c"main");
        let info = [vk::ComputePipelineCreateInfo::default().stage(stage).layout(self.layout)];
        // SAFETY: see above.
        let made = unsafe { raw.create_compute_pipelines(vk::PipelineCache::null(), &info, None) };
        // SAFETY: the module is not needed once the pipeline exists.
        unsafe { raw.destroy_shader_module(module, None) };
        let pipelines = made.map_err(|(_, result)| Error::Vulkan { call: "vkCreateComputePipelines", result })?;
        self.raw = pipelines[0];
        Ok(())
    }
}
