#include "host.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void fail(const char *what) {
    fprintf(stderr, "cornell: %s\n", what);
    exit(EXIT_FAILURE);
}

void require(VkResult result, const char *call) {
    if (result != VK_SUCCESS) {
        fprintf(stderr, "cornell: %s failed with VkResult %d\n", call, (int)result);
        exit(EXIT_FAILURE);
    }
}

static VKAPI_ATTR VkBool32 VKAPI_CALL complain(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                               VkDebugUtilsMessageTypeFlagsEXT type,
                                               const VkDebugUtilsMessengerCallbackDataEXT *data, void *user_data) {
    Host *host = user_data;
    (void)severity;
    (void)type;
    host->complaints++;
    fprintf(stderr, "validation: %s\n", data->pMessage);
    return VK_FALSE;
}

static void pick_physical_device(Host *host) {
    VkPhysicalDevice devices[16];
    uint32_t count = 16;
    VkResult result = vkEnumeratePhysicalDevices(host->instance, &count, devices);
    if (result != VK_INCOMPLETE) require(result, "vkEnumeratePhysicalDevices");
    int best = -1;
    for (uint32_t i = 0; i < count; i++) {
        VkPhysicalDeviceProperties properties;
        vkGetPhysicalDeviceProperties(devices[i], &properties);
        VkQueueFamilyProperties families[16];
        uint32_t family_count = 16;
        vkGetPhysicalDeviceQueueFamilyProperties(devices[i], &family_count, families);
        const int score = properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU ? 2
                          : properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU        ? 0
                                                                                        : 1;
        for (uint32_t family = 0; family < family_count && score > best; family++) {
            const VkQueueFlags both = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
            if (properties.apiVersion >= VK_API_VERSION_1_1 && (families[family].queueFlags & both) == both) {
                best = score;
                host->physical_device = devices[i];
                host->queue_family = family;
            }
        }
    }
    if (best < 0) fail("no Vulkan 1.1 device with a queue for graphics and compute");
    vkGetPhysicalDeviceMemoryProperties(host->physical_device, &host->memory);
}

void host_open(Host *host, bool validate) {
    memset(host, 0, sizeof *host);
    const char *layers[] = {"VK_LAYER_KHRONOS_validation"};
    const char *extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
    const VkValidationFeatureEnableEXT enabled[] = {VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
    const VkValidationFeaturesEXT features = {
        .sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
        .enabledValidationFeatureCount = 1,
        .pEnabledValidationFeatures = enabled,
    };
    const VkDebugUtilsMessengerCreateInfoEXT messages = {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .pNext = &features,
        .messageSeverity =
            VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
        .pfnUserCallback = complain,
        .pUserData = host,
    };
    const VkApplicationInfo application = {
        .sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
        .pApplicationName = "brickgi C sample",
        .apiVersion = VK_API_VERSION_1_1,
    };
    const VkInstanceCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
        .pNext = validate ? &messages : NULL,
        .pApplicationInfo = &application,
        .enabledLayerCount = validate ? 1 : 0,
        .ppEnabledLayerNames = layers,
        .enabledExtensionCount = validate ? 2 : 0,
        .ppEnabledExtensionNames = extensions,
    };
    require(vkCreateInstance(&info, NULL, &host->instance), "vkCreateInstance");
    if (validate) {
        PFN_vkCreateDebugUtilsMessengerEXT create = (PFN_vkCreateDebugUtilsMessengerEXT)vkGetInstanceProcAddr(
            host->instance, "vkCreateDebugUtilsMessengerEXT");
        VkDebugUtilsMessengerCreateInfoEXT messenger = messages;
        messenger.pNext = NULL;
        if (create == NULL) fail("no vkCreateDebugUtilsMessengerEXT");
        require(create(host->instance, &messenger, NULL, &host->messenger), "vkCreateDebugUtilsMessengerEXT");
    }
    pick_physical_device(host);
}

void host_make_device(Host *host) {
    const float priority = 1.0f;
    const VkDeviceQueueCreateInfo queue = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
        .queueFamilyIndex = host->queue_family,
        .queueCount = 1,
        .pQueuePriorities = &priority,
    };
    const VkDeviceCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
        .queueCreateInfoCount = 1,
        .pQueueCreateInfos = &queue,
    };
    require(vkCreateDevice(host->physical_device, &info, NULL, &host->device), "vkCreateDevice");
    vkGetDeviceQueue(host->device, host->queue_family, 0, &host->queue);
    const VkCommandPoolCreateInfo pool = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
        .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
        .queueFamilyIndex = host->queue_family,
    };
    require(vkCreateCommandPool(host->device, &pool, NULL, &host->pool), "vkCreateCommandPool");
}

void host_close(Host *host) {
    vkDestroyCommandPool(host->device, host->pool, NULL);
    vkDestroyDevice(host->device, NULL);
    if (host->messenger != VK_NULL_HANDLE) {
        PFN_vkDestroyDebugUtilsMessengerEXT destroy = (PFN_vkDestroyDebugUtilsMessengerEXT)vkGetInstanceProcAddr(
            host->instance, "vkDestroyDebugUtilsMessengerEXT");
        if (destroy != NULL) destroy(host->instance, host->messenger, NULL);
    }
    vkDestroyInstance(host->instance, NULL);
}

static VkDeviceMemory allocate(const Host *host, VkMemoryRequirements needs, VkMemoryPropertyFlags properties) {
    for (uint32_t type = 0; type < host->memory.memoryTypeCount; type++) {
        if ((needs.memoryTypeBits >> type & 1) == 0) continue;
        if ((host->memory.memoryTypes[type].propertyFlags & properties) != properties) continue;
        const VkMemoryAllocateInfo info = {
            .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
            .allocationSize = needs.size,
            .memoryTypeIndex = type,
        };
        VkDeviceMemory memory;
        require(vkAllocateMemory(host->device, &info, NULL, &memory), "vkAllocateMemory");
        return memory;
    }
    fail("no memory type that fits");
    return VK_NULL_HANDLE;
}

Image host_image(const Host *host, VkFormat format, VkImageUsageFlags usage, VkImageAspectFlags aspect, uint32_t width,
                 uint32_t height) {
    Image image;
    const VkImageCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
        .imageType = VK_IMAGE_TYPE_2D,
        .format = format,
        .extent = {width, height, 1},
        .mipLevels = 1,
        .arrayLayers = 1,
        .samples = VK_SAMPLE_COUNT_1_BIT,
        .usage = usage,
    };
    require(vkCreateImage(host->device, &info, NULL, &image.image), "vkCreateImage");
    VkMemoryRequirements needs;
    vkGetImageMemoryRequirements(host->device, image.image, &needs);
    image.memory = allocate(host, needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    require(vkBindImageMemory(host->device, image.image, image.memory, 0), "vkBindImageMemory");
    const VkImageViewCreateInfo view = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
        .image = image.image,
        .viewType = VK_IMAGE_VIEW_TYPE_2D,
        .format = format,
        .subresourceRange = {aspect, 0, 1, 0, 1},
    };
    require(vkCreateImageView(host->device, &view, NULL, &image.view), "vkCreateImageView");
    return image;
}

void host_free_image(const Host *host, Image *image) {
    vkDestroyImageView(host->device, image->view, NULL);
    vkDestroyImage(host->device, image->image, NULL);
    vkFreeMemory(host->device, image->memory, NULL);
}

static Buffer make_buffer(const Host *host, VkBufferUsageFlags usage, VkDeviceSize size,
                          VkMemoryPropertyFlags properties) {
    Buffer buffer = {VK_NULL_HANDLE, VK_NULL_HANDLE, NULL};
    const VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = size, .usage = usage};
    require(vkCreateBuffer(host->device, &info, NULL, &buffer.buffer), "vkCreateBuffer");
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(host->device, buffer.buffer, &needs);
    buffer.memory = allocate(host, needs, properties);
    require(vkBindBufferMemory(host->device, buffer.buffer, buffer.memory, 0), "vkBindBufferMemory");
    return buffer;
}

Buffer host_buffer(const Host *host, VkBufferUsageFlags usage, VkDeviceSize size) {
    const VkMemoryPropertyFlags mappable = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    Buffer buffer = make_buffer(host, usage, size, mappable);
    require(vkMapMemory(host->device, buffer.memory, 0, size, 0, &buffer.data), "vkMapMemory");
    return buffer;
}

Buffer host_upload(const Host *host, const void *bytes, VkDeviceSize size) {
    const VkBufferUsageFlags both = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    Buffer buffer = make_buffer(host, both, size, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    Buffer staging = host_buffer(host, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, size);
    memcpy(staging.data, bytes, (size_t)size);
    VkCommandBuffer commands;
    const VkCommandBufferAllocateInfo allocate_info = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, .commandPool = host->pool, .commandBufferCount = 1};
    require(vkAllocateCommandBuffers(host->device, &allocate_info, &commands), "vkAllocateCommandBuffers");
    const VkCommandBufferBeginInfo begin = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    require(vkBeginCommandBuffer(commands, &begin), "vkBeginCommandBuffer");
    const VkBufferCopy region = {0, 0, size};
    vkCmdCopyBuffer(commands, staging.buffer, buffer.buffer, 1, &region);
    const VkMemoryBarrier barrier = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
        .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
        .dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT,
    };
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 1, &barrier, 0, NULL,
                         0, NULL);
    require(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
    const VkSubmitInfo submit = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &commands};
    require(vkQueueSubmit(host->queue, 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit");
    require(vkQueueWaitIdle(host->queue), "vkQueueWaitIdle");
    vkFreeCommandBuffers(host->device, host->pool, 1, &commands);
    host_free_buffer(host, &staging);
    return buffer;
}

void host_free_buffer(const Host *host, Buffer *buffer) {
    vkDestroyBuffer(host->device, buffer->buffer, NULL);
    vkFreeMemory(host->device, buffer->memory, NULL);
}
