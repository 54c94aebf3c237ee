//! A host's Vulkan device for tests, with the validation layer on (core and synchronisation).

use ash::{ext, vk};
use std::ffi::{CStr, c_void};
use std::sync::Mutex;

/// Instance, device and a command buffer, and what the validation layer said. Destroyed in order when dropped.
#[allow(dead_code, reason = "each test uses a part")]
pub struct Host {
    pub entry: ash::Entry,
    pub instance: ash::Instance,
    pub physical_device: vk::PhysicalDevice,
    pub device: ash::Device,
    /// Of the device's one queue.
    pub family: u32,
    pub commands: vk::CommandBuffer,
    pool: vk::CommandPool,
    messenger: vk::DebugUtilsMessengerEXT,
    messages: Box<Mutex<Vec<String>>>,
}

unsafe extern "system" fn note(
    _: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    messages: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer hands in a valid struct, and the pointer that the messenger was made with: a boxed Mutex that
    // outlives it.
    let (text, messages) = unsafe { (CStr::from_ptr((*data).p_message), &*messages.cast::<Mutex<Vec<String>>>()) };
    messages.lock().expect("messages").push(text.to_string_lossy().into_owned());
    vk::FALSE
}

impl Host {
    pub fn new() -> Self {
        // SAFETY: ordinary Vulkan set-up; every struct outlives the call that reads it, and every handle is used while
        // it lives.
        unsafe {
            let entry = ash::Entry::load().expect("the Vulkan loader");
            let messages = Box::new(Mutex::new(Vec::new()));
            let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_1);
            let layers = [c"VK_LAYER_KHRONOS_validation".as_ptr()];
            let extensions = [ext::debug_utils::NAME.as_ptr(), c"VK_EXT_validation_features".as_ptr()];
            let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
            let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
            let info = vk::InstanceCreateInfo::default()
                .application_info(&application)
                .enabled_layer_names(&layers)
                .enabled_extension_names(&extensions)
                .push_next(&mut features);
            let instance = entry.create_instance(&info, None).expect("an instance with the validation layer");
            let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
                .message_severity(
                    vk::DebugUtilsMessageSeverityFlagsEXT::WARNING | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
                )
                .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
                .pfn_user_callback(Some(note))
                .user_data(std::ptr::from_ref(&*messages).cast_mut().cast());
            let debug = ext::debug_utils::Instance::new(&entry, &instance);
            let messenger = debug.create_debug_utils_messenger(&info, None).expect("a messenger");
            let (physical_device, family) = pick(&instance);
            let priorities = [1.0];
            let queues =
                [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&priorities)];
            let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues);
            let device = instance.create_device(physical_device, &info, None).expect("a device");
            let info = vk::CommandPoolCreateInfo::default().queue_family_index(family);
            let pool = device.create_command_pool(&info, None).expect("a command pool");
            let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            let commands = device.allocate_command_buffers(&info).expect("a command buffer")[0];
            Self { entry, instance, physical_device, device, family, commands, pool, messenger, messages }
        }
    }

    /// What the validation layer said so far.
    pub fn messages(&self) -> Vec<String> {
        self.messages.lock().expect("messages").clone()
    }
}

/// The first device with a queue family for compute and graphics.
unsafe fn pick(instance: &ash::Instance) -> (vk::PhysicalDevice, u32) {
    let both = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    // SAFETY: the instance lives.
    let devices = unsafe { instance.enumerate_physical_devices() }.expect("physical devices");
    let found = devices.into_iter().find_map(|device| {
        // SAFETY: the physical device is the instance's.
        let families = unsafe { instance.get_physical_device_queue_family_properties(device) };
        let family = families.iter().position(|family| family.queue_flags.contains(both))?;
        Some((device, family as u32))
    });
    found.expect("a device with a queue for graphics and compute")
}

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: children before parents; the tests have destroyed what they made.
        unsafe {
            self.device.destroy_command_pool(self.pool, None);
            self.device.destroy_device(None);
            let debug = ext::debug_utils::Instance::new(&self.entry, &self.instance);
            debug.destroy_debug_utils_messenger(self.messenger, None);
            self.instance.destroy_instance(None);
        }
    }
}
