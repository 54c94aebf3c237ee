//! What the misuse tests work on: a live context with a view, and every struct in a valid state, to be spoilt.

#![allow(dead_code, reason = "each test program uses a part")]

use crate::vulkan::Host;
use ash::vk;
use ash::vk::Handle;
use brickgi::capi::*;
use std::ffi::{CStr, c_char};
use std::ptr::{null, null_mut, without_provenance_mut};

/// A struct with its sType and the fields that are named; the rest is zero.
macro_rules! structure {
    ($name:ident, $type:ident, $($field:ident: $value:expr),* $(,)?) => {
        $name { s_type: $type, $($field: $value,)* ..zeroed() }
    };
}

/// A name, the code that is expected, a word that the text must have, and the bad call.
pub type Row = (&'static str, BgiResult, &'static str, fn(&Bench) -> BgiResult);

/// A live context with a view, on a live device.
pub struct Bench {
    pub host: Host,
    pub context: BgiContext,
    pub view: BgiView,
}

pub fn zeroed<T>() -> T {
    // SAFETY: used for the header's structs alone: plain numbers, pointers and optional functions.
    unsafe { std::mem::zeroed() }
}

pub fn last_error(context: BgiContext) -> String {
    let mut text = [0 as c_char; 1024];
    // SAFETY: the array is as long as said; the text ends with a zero.
    unsafe {
        bgiGetLastError(context, text.as_mut_ptr(), text.len());
        CStr::from_ptr(text.as_ptr()).to_str().expect("UTF-8").to_owned()
    }
}

impl Bench {
    pub fn new() -> Self {
        let mut bench = Self { host: Host::new(), context: null_mut(), view: null_mut() };
        bench.context = bench.make_context();
        bench.view = bench.make_view(bench.context);
        bench
    }

    pub fn create_info(&self) -> BgiContextCreateInfo {
        structure! { BgiContextCreateInfo, BGI_STRUCTURE_TYPE_CONTEXT_CREATE_INFO,
            abi_version: BGI_ABI_VERSION,
            frames_in_flight: 2,
            get_instance_proc_addr: Some(self.host.entry.static_fn().get_instance_proc_addr),
            instance: self.host.instance.handle(),
            physical_device: self.host.physical_device,
            device: self.host.device.handle(),
        }
    }

    pub fn query(&self) -> BgiDeviceQuery {
        structure! { BgiDeviceQuery, BGI_STRUCTURE_TYPE_DEVICE_QUERY,
            get_instance_proc_addr: Some(self.host.entry.static_fn().get_instance_proc_addr),
            instance: self.host.instance.handle(),
            physical_device: self.host.physical_device,
        }
    }

    pub fn make_context(&self) -> BgiContext {
        let mut context = null_mut();
        // SAFETY: as the header says.
        let result = unsafe { bgiCreateContext(&self.create_info(), &mut context) };
        assert_eq!(result, BGI_SUCCESS, "{}", last_error(null_mut()));
        context
    }

    pub fn make_view(&self, context: BgiContext) -> BgiView {
        let mut view = null_mut();
        // SAFETY: as the header says.
        let result = unsafe { bgiCreateView(context, &view_info(), &mut view) };
        assert_eq!(result, BGI_SUCCESS, "{}", last_error(context));
        view
    }

    pub fn create(&self, change: impl FnOnce(&mut BgiContextCreateInfo)) -> BgiResult {
        let mut info = self.create_info();
        change(&mut info);
        // Not NULL before, so that it is seen to become so.
        let mut context = without_provenance_mut(1);
        // SAFETY: misuse that the header says is survived.
        let result = unsafe { bgiCreateContext(&info, &mut context) };
        assert!(context.is_null());
        result
    }

    pub fn create_with(&self, change: impl FnOnce(&mut BgiSettings)) -> BgiResult {
        let mut settings = settings();
        change(&mut settings);
        self.create(|info| info.settings = &settings)
    }

    pub fn dispatch(&self, change: impl FnOnce(&mut BgiDispatchInfo)) -> BgiResult {
        let mut info = structure! { BgiDispatchInfo, BGI_STRUCTURE_TYPE_DISPATCH_INFO,
            command_buffer: self.host.commands,
            view: self.view,
            depth: vk::ImageView::from_raw(1),
            normal: vk::ImageView::from_raw(2),
            output: vk::ImageView::from_raw(3),
            output_format: vk::Format::R32G32B32A32_SFLOAT,
            width: 16,
            height: 16,
        };
        change(&mut info);
        // SAFETY: refused before any handle is used.
        unsafe { bgiDispatch(self.context, &info) }
    }

    pub fn update(&self, change: impl FnOnce(&mut BgiMeshUpdate)) -> BgiResult {
        let mut update = structure! { BgiMeshUpdate, BGI_STRUCTURE_TYPE_MESH_UPDATE, };
        change(&mut update);
        // SAFETY: misuse that the header says is survived.
        unsafe { bgiUpdateMeshes(self.context, &update) }
    }

    pub fn update_mesh(&self, change: impl FnOnce(&mut BgiMesh)) -> BgiResult {
        let mut mesh = mesh();
        change(&mut mesh);
        self.update(|update| (update.meshes, update.mesh_count) = (&mesh, 1))
    }

    /// An update of a mesh in a buffer, and of another one that is as good.
    pub fn update_buffer_mesh(&self, change: impl FnOnce(&mut BgiMesh, &mut BgiMesh)) -> BgiResult {
        let device = &self.host.device;
        let info = vk::BufferCreateInfo::default().size(256).usage(vk::BufferUsageFlags::TRANSFER_SRC);
        // SAFETY: a live device; the update is refused, so that nothing reads the buffer.
        let buffer = unsafe { device.create_buffer(&info, None) }.expect("a buffer");
        let mut mesh = mesh();
        (mesh.positions.data, mesh.positions.buffer) = (null(), buffer);
        (mesh.indices.data, mesh.indices.buffer) = (null(), buffer);
        let mut meshes = [mesh, BgiMesh { id: 2, ..mesh }];
        let [first, second] = &mut meshes;
        change(first, second);
        let result = self.update(|update| (update.meshes, update.mesh_count) = (meshes.as_ptr(), 2));
        // SAFETY: as above.
        unsafe { device.destroy_buffer(buffer, None) };
        result
    }

    pub fn update_instance(&self, change: impl FnOnce(&mut BgiInstance)) -> BgiResult {
        let (mesh, material) = (mesh(), structure! { BgiMaterial, BGI_STRUCTURE_TYPE_MATERIAL, id: 1, });
        let linear = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut instance = structure! { BgiInstance, BGI_STRUCTURE_TYPE_INSTANCE,
            mesh: 1, material: 1, linear: linear,
        };
        change(&mut instance);
        self.update(|update| {
            (update.meshes, update.mesh_count) = (&mesh, 1);
            (update.materials, update.material_count) = (&material, 1);
            (update.instances, update.instance_count) = (&instance, 1);
        })
    }

    pub fn update_material(&self, change: impl FnOnce(&mut BgiMaterial)) -> BgiResult {
        let mut material = structure! { BgiMaterial, BGI_STRUCTURE_TYPE_MATERIAL, };
        change(&mut material);
        self.update(|update| (update.materials, update.material_count) = (&material, 1))
    }

    pub fn update_texture(&self, change: impl FnOnce(&mut BgiTexture)) -> BgiResult {
        let mut texture = structure! { BgiTexture, BGI_STRUCTURE_TYPE_TEXTURE,
            width: 1, height: 1, rgba8: [0; 4].as_ptr(),
        };
        change(&mut texture);
        self.update(|update| (update.textures, update.texture_count) = (&texture, 1))
    }

    pub fn light(&self, change: impl FnOnce(&mut BgiLight)) -> BgiResult {
        let mut light = structure! { BgiLight, BGI_STRUCTURE_TYPE_LIGHT,
            light_type: BGI_LIGHT_TYPE_DIRECTIONAL, direction: [0.0, -1.0, 0.0],
        };
        change(&mut light);
        self.lighting(|lighting| (lighting.lights, lighting.light_count) = (&light, 1))
    }

    pub fn lighting(&self, change: impl FnOnce(&mut BgiLighting)) -> BgiResult {
        let mut lighting = structure! { BgiLighting, BGI_STRUCTURE_TYPE_LIGHTING, };
        change(&mut lighting);
        // SAFETY: misuse that the header says is survived.
        unsafe { bgiSetLights(self.context, &lighting) }
    }

    /// Five lights: directional, point, spot, sphere, rectangle. Two maps of a layer each, of the first two.
    pub fn shadow_maps(&self, change: impl FnOnce(&mut [BgiShadowMap; 2], &mut [BgiShadowLayer; 2])) -> BgiResult {
        let light = |light_type| {
            structure! { BgiLight, BGI_STRUCTURE_TYPE_LIGHT,
                light_type: light_type, direction: [0.0, -1.0, 0.0], outer_angle: 0.5, radius: 1.0,
                half_axis_u: [1.0, 0.0, 0.0], half_axis_v: [0.0, 1.0, 0.0],
            }
        };
        let lights = [1, 2, 3, 4, 5].map(light);
        let result = self.lighting(|lighting| (lighting.lights, lighting.light_count) = (lights.as_ptr(), 5));
        assert_eq!(result, BGI_SUCCESS, "{}", last_error(self.context));
        let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut layers = [structure! { BgiShadowLayer, BGI_STRUCTURE_TYPE_SHADOW_LAYER,
            view_rotation: identity,
            projection: std::array::from_fn(|i| std::array::from_fn(|k| if i == k { 1.0 } else { 0.0 })),
        }; 2];
        let mut maps = [0, 1].map(|light| structure! { BgiShadowMap, BGI_STRUCTURE_TYPE_SHADOW_MAP,
            light: light, width: 64, height: 32, layer_count: 1, view: vk::ImageView::from_raw(7), layers: &layers[0],
        });
        maps[1].layers = &raw const layers[1];
        change(&mut maps, &mut layers);
        // SAFETY: misuse that the header says is survived.
        unsafe { bgiSetShadowMaps(self.context, 2, maps.as_ptr()) }
    }

    pub fn sky(&self, change: impl FnOnce(&mut BgiSky)) -> BgiResult {
        let mut sky = structure! { BgiSky, BGI_STRUCTURE_TYPE_SKY,
            sky_type: BGI_SKY_TYPE_GRADIENT, up: [0.0, 1.0, 0.0],
        };
        change(&mut sky);
        self.lighting(|lighting| lighting.sky = &sky)
    }

    /// A cube of 2 x 2 texels a face, 4 bytes each.
    pub fn sky_image(&self, change: impl FnOnce(&mut BgiSkyImage)) -> BgiResult {
        let texels = [0u32; 24];
        let mut image = structure! { BgiSkyImage, BGI_STRUCTURE_TYPE_SKY_IMAGE,
            layout: BGI_SKY_LAYOUT_CUBE, format: vk::Format::B10G11R11_UFLOAT_PACK32, width: 2, height: 2,
            texels: texels.as_ptr().cast(), texels_size: 96,
        };
        change(&mut image);
        // SAFETY: misuse that the header says is survived.
        unsafe { bgiSetSkyImage(self.context, &image) }
    }

    pub fn camera(&self, change: impl FnOnce(&mut BgiCamera)) -> BgiResult {
        let mut camera = structure! { BgiCamera, BGI_STRUCTURE_TYPE_CAMERA,
            view_rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            projection: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, -1.0], [0.0, 0.0, 0.1, 0.0]],
        };
        change(&mut camera);
        // SAFETY: misuse that the header says is survived.
        unsafe { bgiSetCamera(self.context, self.view, &camera) }
    }

    pub fn view(&self, change: impl FnOnce(&mut BgiViewCreateInfo)) -> BgiResult {
        let mut info = view_info();
        change(&mut info);
        let mut view = without_provenance_mut(1);
        // SAFETY: misuse that the header says is survived.
        let result = unsafe { bgiCreateView(self.context, &info, &mut view) };
        assert!(view.is_null());
        result
    }

    pub fn stats(&self, change: impl FnOnce(&mut BgiStats)) -> BgiResult {
        let mut stats = structure! { BgiStats, BGI_STRUCTURE_TYPE_STATS, };
        change(&mut stats);
        // SAFETY: misuse that the header says is survived.
        unsafe { bgiGetStats(self.context, &mut stats) }
    }

    pub fn expect(&self, table: &[Row]) {
        for (name, code, word, call) in table {
            let result = call(self);
            let text = last_error(null_mut());
            assert_eq!(result, *code, "{name}: {text}");
            assert!(text.to_lowercase().contains(word), "{name}: \"{text}\" says nothing of {word}");
        }
        assert_eq!(self.lighting(|_| ()), BGI_SUCCESS, "the context goes on");
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        // SAFETY: nothing was submitted.
        let result = unsafe { bgiDestroyContext(self.context) };
        if !std::thread::panicking() {
            assert_eq!(result, BGI_SUCCESS);
            assert_eq!(self.host.messages(), Vec::<String>::new(), "the validation layer stays silent");
        }
    }
}

pub fn settings() -> BgiSettings {
    let mut settings = structure! { BgiSettings, BGI_STRUCTURE_TYPE_SETTINGS, };
    // SAFETY: as the header says.
    assert_eq!(unsafe { bgiGetDefaultSettings(BGI_PRESET_MEDIUM, &mut settings) }, BGI_SUCCESS);
    settings
}

pub fn view_info() -> BgiViewCreateInfo {
    structure! { BgiViewCreateInfo, BGI_STRUCTURE_TYPE_VIEW_CREATE_INFO, width: 16, height: 16, }
}

pub fn mesh() -> BgiMesh {
    static POSITIONS: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    static INDICES: [u32; 3] = [0, 1, 2];
    structure! { BgiMesh, BGI_STRUCTURE_TYPE_MESH,
        id: 1, vertex_count: 3, index_count: 3, positions: floats(&POSITIONS), indices: indices(&INDICES),
    }
}

/// An attribute in host memory.
pub fn floats(values: &[f32]) -> BgiVertexData {
    BgiVertexData { data: values.as_ptr().cast(), format: BGI_VERTEX_FORMAT_FLOAT32, ..zeroed() }
}

/// Indices in host memory.
pub fn indices(values: &[u32]) -> BgiIndexData {
    BgiIndexData { data: values.as_ptr().cast(), index_type: BGI_INDEX_TYPE_UINT32, ..zeroed() }
}

/// As [`floats`], of the bits of half floats.
pub fn halves(bits: &[u16]) -> BgiVertexData {
    BgiVertexData { data: bits.as_ptr().cast(), format: BGI_VERTEX_FORMAT_FLOAT16, ..zeroed() }
}

/// As [`indices`], of 16 bits.
pub fn short_indices(values: &[u16]) -> BgiIndexData {
    BgiIndexData { data: values.as_ptr().cast(), index_type: BGI_INDEX_TYPE_UINT16, ..zeroed() }
}
