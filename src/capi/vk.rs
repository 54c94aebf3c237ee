//! Vulkan's types under Vulkan's names, so that the generated header says `VkDevice` and includes Vulkan's own header.
//! The generator is not shown this file.

use ash::vk;

pub type VkInstance = vk::Instance;
pub type VkPhysicalDevice = vk::PhysicalDevice;
pub type VkDevice = vk::Device;
pub type VkBuffer = vk::Buffer;
pub type VkCommandBuffer = vk::CommandBuffer;
pub type VkImageView = vk::ImageView;
pub type VkFormat = vk::Format;
/// A C function pointer may be NULL.
pub type PFN_vkGetInstanceProcAddr = Option<vk::PFN_vkGetInstanceProcAddr>;
