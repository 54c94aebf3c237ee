//! Collects what the Khronos validation layer says.

use crate::error::{Error, Result};
use ash::{ext::debug_utils, vk};
use std::ffi::c_void;
use std::sync::Mutex;
use wgpu_hal::vulkan::InstanceShared;

/// A debug messenger with its list; lives as long as the instance.
pub(crate) struct Validation {
    extension: debug_utils::Instance,
    messenger: vk::DebugUtilsMessengerEXT,
    /// Boxed: the driver holds its address.
    messages: Box<Mutex<Vec<String>>>,
}

impl Validation {
    /// Fails where the layer is not installed, so that silence always means a clean run.
    pub(crate) fn install(instance: &InstanceShared) -> Result<Self> {
        if !layer_is_installed(instance.entry()) || !instance.extensions().contains(&debug_utils::NAME) {
            return Err(Error::NoDevice("VK_LAYER_KHRONOS_validation is not installed".into()));
        }
        let messages = Box::new(Mutex::new(Vec::new()));
        let address: *const Mutex<Vec<String>> = &*messages;
        let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(
                vk::DebugUtilsMessageSeverityFlagsEXT::WARNING | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
            )
            .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
            .pfn_user_callback(Some(collect))
            .user_data(address.cast_mut().cast());
        let extension = debug_utils::Instance::new(instance.entry(), instance.raw_instance());
        // SAFETY: the extension is enabled; `messages` lives until the messenger is destroyed in `drop`.
        let messenger = unsafe { extension.create_debug_utils_messenger(&info, None) };
        let messenger = messenger.map_err(Error::gpu("vkCreateDebugUtilsMessengerEXT"))?;
        Ok(Self { extension, messenger, messages })
    }

    /// Every warning and error so far, in order.
    pub(crate) fn messages(&self) -> Vec<String> {
        self.messages.lock().map(|list| list.clone()).unwrap_or_default()
    }
}

impl Drop for Validation {
    fn drop(&mut self) {
        // SAFETY: created by the same extension object; the instance is still alive (field order of `Gpu`).
        unsafe { self.extension.destroy_debug_utils_messenger(self.messenger, None) };
    }
}

fn layer_is_installed(entry: &ash::Entry) -> bool {
    // SAFETY: a global command without parameters.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }.unwrap_or_default();
    layers.iter().any(|layer| layer.layer_name_as_c_str() == Ok(c"VK_LAYER_KHRONOS_validation"))
}

/// SAFETY: called by the layer with the pointer given at creation, which outlives the messenger.
unsafe extern "system" fn collect(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer passes valid data; `user` is the boxed list.
    let (text, messages) = unsafe {
        let text = (*data).message_as_c_str().map(|text| text.to_string_lossy().into_owned());
        (text.unwrap_or_default(), &*user.cast_const().cast::<Mutex<Vec<String>>>())
    };
    if let Ok(mut messages) = messages.lock() {
        messages.push(text);
    }
    vk::FALSE
}
