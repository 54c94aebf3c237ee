/* A small Vulkan host: instance, device, images, buffers. Nothing here knows the library. A failure ends the program. */
#ifndef HOST_H
#define HOST_H

#include <stdbool.h>
#include <vulkan/vulkan.h>

typedef struct Host {
    VkInstance instance;
    VkDebugUtilsMessengerEXT messenger;
    unsigned complaints; /* validation messages so far */
    VkPhysicalDevice physical_device;
    VkPhysicalDeviceMemoryProperties memory;
    uint32_t queue_family;
    VkDevice device;
    VkQueue queue;
    VkCommandPool pool;
} Host;

typedef struct Image {
    VkImage image;
    VkDeviceMemory memory;
    VkImageView view;
} Image;

/* Mapped for its whole life, or, where `data` is NULL, out of the host's reach. */
typedef struct Buffer {
    VkBuffer buffer;
    VkDeviceMemory memory;
    void *data;
} Buffer;

/* Prints and ends the program. */
void fail(const char *what);
void require(VkResult result, const char *call);

/* Makes the instance and picks a physical device: a GPU before a software driver. */
void host_open(Host *host, bool validate);
/* Makes the device, with one queue for graphics and compute. */
void host_make_device(Host *host);
void host_close(Host *host);

Image host_image(const Host *host, VkFormat format, VkImageUsageFlags usage, VkImageAspectFlags aspect, uint32_t width,
                 uint32_t height);
void host_free_image(const Host *host, Image *image);
/* Host-visible and coherent. */
Buffer host_buffer(const Host *host, VkBufferUsageFlags usage, VkDeviceSize size);
/* Device-local, filled with the given bytes and ready to be copied from; not mapped. */
Buffer host_upload(const Host *host, const void *bytes, VkDeviceSize size);
void host_free_buffer(const Host *host, Buffer *buffer);

#endif
