/* The Cornell box, lit by brickgi, from C.

   cornell [--camera a|b] [--frames N] [--size WxH] [--voxel-size METRES] [--out PREFIX] [--mesh-buffers]
           [--validate]

With --mesh-buffers the library reads the meshes from VkBuffers instead of host memory. Writes the indirect irradiance
E_ind after the last frame to PREFIX.pfm (as it is) and PREFIX.ppm (tone-mapped). Ends with 0 only where everything worked
and, with --validate, the validation layer had nothing to say.

The host's side (Vulkan, G-buffer, files) lies in host.c, gbuffer.c and picture.c; everything that an engine would add
for the library stands between the two lines of equals signs. */
#include <brickgi.h>

#include "gbuffer.h"
#include "host.h"
#include "picture.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FRAMES_IN_FLIGHT = 2 };

typedef struct Options {
    const CornellCamera *camera;
    uint32_t frames, width, height;
    float voxel_size; /* metres; 0: the library's default */
    const char *out;
    bool mesh_buffers, validate;
} Options;

/* ================================================================================================================= */

typedef struct Gi {
    BgiContext context;
    BgiView view;
} Gi;

/* Every call answers with a code; the words are one call away. */
static void check(BgiContext context, BgiResult result, const char *call) {
    if (result >= 0) return;
    char text[512];
    bgiGetLastError(context, text, sizeof text);
    fprintf(stderr, "cornell: %s: %s: %s\n", call, bgiResultName(result), text);
    exit(EXIT_FAILURE);
}

/* Before the device is made: will it do? */
static void gi_ask(const Host *host) {
    char missing[1024] = "";
    const BgiDeviceQuery query = {
        .sType = BGI_STRUCTURE_TYPE_DEVICE_QUERY,
        .getInstanceProcAddr = vkGetInstanceProcAddr,
        .instance = host->instance,
        .physicalDevice = host->physical_device,
    };
    BgiDeviceRequirements needs = {
        .sType = BGI_STRUCTURE_TYPE_DEVICE_REQUIREMENTS,
        .missingSize = sizeof missing,
        .missing = missing,
    };
    check(NULL, bgiGetDeviceRequirements(&query, &needs), "bgiGetDeviceRequirements");
    if (!needs.supported) fail(missing);
}

static void gi_create(Gi *gi, const Host *host, const Options *options) {
    BgiSettings settings = {.sType = BGI_STRUCTURE_TYPE_SETTINGS};
    check(NULL, bgiGetDefaultSettings(BGI_PRESET_MEDIUM, &settings), "bgiGetDefaultSettings");
    if (options->voxel_size > 0.0f) settings.voxelSize = options->voxel_size;
    const BgiContextCreateInfo info = {
        .sType = BGI_STRUCTURE_TYPE_CONTEXT_CREATE_INFO,
        .abiVersion = BGI_ABI_VERSION,
        .framesInFlight = FRAMES_IN_FLIGHT,
        .getInstanceProcAddr = vkGetInstanceProcAddr,
        .instance = host->instance,
        .physicalDevice = host->physical_device,
        .device = host->device,
        .settings = &settings,
    };
    check(NULL, bgiCreateContext(&info, &gi->context), "bgiCreateContext");
    const BgiViewCreateInfo view = {
        .sType = BGI_STRUCTURE_TYPE_VIEW_CREATE_INFO, .width = options->width, .height = options->height};
    check(gi->context, bgiCreateView(gi->context, &view, &gi->view), "bgiCreateView");
}

/* One mesh, material and instance for each part of the box; the lamp is a material that emits. The meshes lie in host
   memory or, where there are buffers, in these. */
static void gi_set_scene(const Gi *gi, const Buffer *vertices, const Buffer *indices) {
    BgiMaterial materials[CORNELL_PARTS];
    BgiMesh meshes[CORNELL_PARTS];
    BgiInstance instances[CORNELL_PARTS];
    for (uint32_t i = 0; i < CORNELL_PARTS; i++) {
        const CornellPart *part = &cornell_parts[i];
        materials[i] = (BgiMaterial){.sType = BGI_STRUCTURE_TYPE_MATERIAL, .id = i};
        memcpy(materials[i].baseColor, part->base_color, sizeof part->base_color);
        memcpy(materials[i].emission, part->emission, sizeof part->emission);
        meshes[i] = (BgiMesh){
            .sType = BGI_STRUCTURE_TYPE_MESH,
            .id = i,
            .vertexCount = part->vertex_count,
            .indexCount = part->index_count,
            .positions = {.data = cornell_positions[part->first_vertex], .format = BGI_VERTEX_FORMAT_FLOAT32},
            .indices = {.data = &cornell_indices[part->first_index], .indexType = BGI_INDEX_TYPE_UINT32},
        };
        if (vertices->buffer != VK_NULL_HANDLE) {
            meshes[i].positions.data = meshes[i].indices.data = NULL;
            meshes[i].positions.buffer = vertices->buffer;
            meshes[i].positions.offset = part->first_vertex * sizeof cornell_positions[0];
            meshes[i].indices.buffer = indices->buffer;
            meshes[i].indices.offset = part->first_index * sizeof cornell_indices[0];
        }
        instances[i] = (BgiInstance){
            .sType = BGI_STRUCTURE_TYPE_INSTANCE,
            .id = i,
            .mesh = i,
            .material = i,
            .linear = {{1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, {0.0f, 0.0f, 1.0f}},
        };
    }
    const BgiMeshUpdate update = {
        .sType = BGI_STRUCTURE_TYPE_MESH_UPDATE,
        .materials = materials,
        .meshes = meshes,
        .instances = instances,
        .materialCount = CORNELL_PARTS,
        .meshCount = CORNELL_PARTS,
        .instanceCount = CORNELL_PARTS,
    };
    check(gi->context, bgiUpdateMeshes(gi->context, &update), "bgiUpdateMeshes");
    const BgiLighting lighting = {.sType = BGI_STRUCTURE_TYPE_LIGHTING}; /* no sun, no sky: the lamp is all there is */
    check(gi->context, bgiSetLights(gi->context, &lighting), "bgiSetLights");
}

/* Each frame, between the G-buffer and the lighting pass. */
static void gi_record(const Gi *gi, VkCommandBuffer commands, const Camera *camera, const Gbuffer *gbuffer,
                      const Image *output) {
    BgiCamera view = {.sType = BGI_STRUCTURE_TYPE_CAMERA};
    memcpy(view.position, camera->position, sizeof view.position);
    memcpy(view.viewRotation, camera->view_rotation, sizeof view.viewRotation);
    memcpy(view.projection, camera->projection, sizeof view.projection);
    check(gi->context, bgiSetCamera(gi->context, gi->view, &view), "bgiSetCamera");
    const BgiDispatchInfo info = {
        .sType = BGI_STRUCTURE_TYPE_DISPATCH_INFO,
        .commandBuffer = commands,
        .view = gi->view,
        .depth = gbuffer->depth.view,
        .normal = gbuffer->normal.view,
        .output = output->view,
        .outputFormat = VK_FORMAT_R32G32B32A32_SFLOAT,
        .clearDepth = 0.0f,
        .width = gbuffer->width,
        .height = gbuffer->height,
    };
    check(gi->context, bgiDispatch(gi->context, &info), "bgiDispatch");
}

/* ================================================================================================================= */

static void print_stats(const Gi *gi) {
    BgiPassTime passes[32];
    BgiStats stats = {.sType = BGI_STRUCTURE_TYPE_STATS, .passCount = 32, .passes = passes};
    check(gi->context, bgiGetStats(gi->context, &stats), "bgiGetStats");
    if (stats.meshesPending > 0) printf("%u meshes are not read yet\n", (unsigned)stats.meshesPending);
    printf("frame %.3f ms, CPU %.3f ms; world %.2f MiB, views %.2f MiB; bricks %u, faces %u\n", stats.frameMs,
           stats.cpuMs, (double)stats.worldBytes / 1048576.0, (double)stats.viewBytes / 1048576.0,
           (unsigned)stats.bricks, (unsigned)stats.faces);
    for (uint32_t i = 0; i < stats.passCount; i++) printf("  %-16s %8.3f ms\n", passes[i].name, passes[i].ms);
}

static void move_output(VkCommandBuffer commands, const Image *output, VkPipelineStageFlags from,
                        VkPipelineStageFlags to, VkImageMemoryBarrier barrier) {
    barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
    barrier.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = output->image;
    barrier.subresourceRange = (VkImageSubresourceRange){VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    vkCmdPipelineBarrier(commands, from, to, 0, 0, NULL, 0, NULL, 1, &barrier);
}

static void record_frame(const Gi *gi, VkCommandBuffer commands, const Camera *camera, const Gbuffer *gbuffer,
                         const Image *output) {
    gbuffer_draw(gbuffer, commands, camera);
    /* The last frame's contents are done with. */
    move_output(commands, output, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                (VkImageMemoryBarrier){.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT,
                                       .dstAccessMask = VK_ACCESS_SHADER_WRITE_BIT,
                                       .oldLayout = VK_IMAGE_LAYOUT_UNDEFINED,
                                       .newLayout = VK_IMAGE_LAYOUT_GENERAL});
    gi_record(gi, commands, camera, gbuffer, output);
}

static void record_readback(VkCommandBuffer commands, const Image *output, const Buffer *pixels, uint32_t width,
                            uint32_t height) {
    move_output(commands, output, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT,
                (VkImageMemoryBarrier){.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT,
                                       .dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT,
                                       .oldLayout = VK_IMAGE_LAYOUT_GENERAL,
                                       .newLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL});
    const VkBufferImageCopy region = {
        .imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
        .imageExtent = {width, height, 1},
    };
    vkCmdCopyImageToBuffer(commands, output->image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, pixels->buffer, 1, &region);
    const VkMemoryBarrier to_host = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
        .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
        .dstAccessMask = VK_ACCESS_HOST_READ_BIT,
    };
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &to_host, 0, NULL,
                         0, NULL);
}

/* Draws all frames, at most FRAMES_IN_FLIGHT of them at once; the last one's output ends in `pixels`. */
static void render(const Gi *gi, const Host *host, const Options *options, const Gbuffer *gbuffer, const Image *output,
                   const Buffer *pixels) {
    const Camera camera = camera_of(options->camera, options->width, options->height);
    VkCommandBuffer commands[FRAMES_IN_FLIGHT];
    VkFence done[FRAMES_IN_FLIGHT];
    const VkCommandBufferAllocateInfo allocate = {
        .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
        .commandPool = host->pool,
        .commandBufferCount = FRAMES_IN_FLIGHT,
    };
    require(vkAllocateCommandBuffers(host->device, &allocate, commands), "vkAllocateCommandBuffers");
    for (uint32_t i = 0; i < FRAMES_IN_FLIGHT; i++) {
        const VkFenceCreateInfo fence = {
            .sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, .flags = VK_FENCE_CREATE_SIGNALED_BIT};
        require(vkCreateFence(host->device, &fence, NULL, &done[i]), "vkCreateFence");
    }
    for (uint32_t frame = 0; frame < options->frames; frame++) {
        const uint32_t slot = frame % FRAMES_IN_FLIGHT;
        require(vkWaitForFences(host->device, 1, &done[slot], VK_TRUE, UINT64_MAX), "vkWaitForFences");
        require(vkResetFences(host->device, 1, &done[slot]), "vkResetFences");
        const VkCommandBufferBeginInfo begin = {
            .sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
        require(vkBeginCommandBuffer(commands[slot], &begin), "vkBeginCommandBuffer");
        record_frame(gi, commands[slot], &camera, gbuffer, output);
        if (frame + 1 == options->frames)
            record_readback(commands[slot], output, pixels, options->width, options->height);
        require(vkEndCommandBuffer(commands[slot]), "vkEndCommandBuffer");
        const VkSubmitInfo submit = {
            .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &commands[slot]};
        require(vkQueueSubmit(host->queue, 1, &submit, done[slot]), "vkQueueSubmit");
    }
    require(vkDeviceWaitIdle(host->device), "vkDeviceWaitIdle");
    for (uint32_t i = 0; i < FRAMES_IN_FLIGHT; i++) vkDestroyFence(host->device, done[i], NULL);
}

static Options parse(int count, char **arguments) {
    Options options = {&cornell_cameras[0], 64, 320, 180, 0.0f, "cornell", false, false};
    for (int i = 1; i < count; i++) {
        const char *name = arguments[i];
        if (strcmp(name, "--validate") == 0) {
            options.validate = true;
            continue;
        }
        if (strcmp(name, "--mesh-buffers") == 0) {
            options.mesh_buffers = true;
            continue;
        }
        const char *value = ++i < count ? arguments[i] : "";
        unsigned a = 0, b = 0;
        char rest;
        bool good = false;
        if (strcmp(name, "--camera") == 0) {
            for (int k = 0; k < CORNELL_CAMERAS; k++) {
                if (strlen(value) != 1 || value[0] != cornell_cameras[k].name) continue;
                options.camera = &cornell_cameras[k];
                good = true;
            }
        } else if (strcmp(name, "--frames") == 0) {
            good = sscanf(value, "%u%c", &a, &rest) == 1 && a > 0;
            options.frames = a;
        } else if (strcmp(name, "--size") == 0) {
            good = sscanf(value, "%ux%u%c", &a, &b, &rest) == 2 && a > 0 && b > 0 && a <= 4096 && b <= 4096;
            options.width = a;
            options.height = b;
        } else if (strcmp(name, "--voxel-size") == 0) {
            good = sscanf(value, "%f%c", &options.voxel_size, &rest) == 1 && options.voxel_size > 0.0f;
        } else if (strcmp(name, "--out") == 0) {
            options.out = value;
            good = value[0] != '\0';
        }
        if (!good)
            fail("usage: cornell [--camera a|b] [--frames N] [--size WxH] [--voxel-size METRES] [--out PREFIX] "
                 "[--mesh-buffers] [--validate]");
    }
    return options;
}

int main(int count, char **arguments) {
    const Options options = parse(count, arguments);
    Host host;
    Gbuffer gbuffer;
    Gi gi;
    host_open(&host, options.validate);
    gi_ask(&host);
    host_make_device(&host);
    gbuffer_create(&gbuffer, &host, options.width, options.height);
    Image output = host_image(&host, VK_FORMAT_R32G32B32A32_SFLOAT,
                              VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT, VK_IMAGE_ASPECT_COLOR_BIT,
                              options.width, options.height);
    Buffer pixels = host_buffer(&host, VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                                (VkDeviceSize)options.width * options.height * 4 * sizeof(float));

    Buffer vertices = {VK_NULL_HANDLE, VK_NULL_HANDLE, NULL}, indices = vertices;
    if (options.mesh_buffers) {
        vertices = host_upload(&host, cornell_positions, sizeof cornell_positions);
        indices = host_upload(&host, cornell_indices, sizeof cornell_indices);
    }

    gi_create(&gi, &host, &options);
    gi_set_scene(&gi, &vertices, &indices);
    render(&gi, &host, &options, &gbuffer, &output, &pixels);
    print_stats(&gi);
    check(gi.context, bgiDestroyContext(gi.context), "bgiDestroyContext");

    write_pfm(options.out, pixels.data, options.width, options.height);
    write_ppm(options.out, pixels.data, options.width, options.height);
    host_free_buffer(&host, &indices);
    host_free_buffer(&host, &vertices);
    host_free_buffer(&host, &pixels);
    host_free_image(&host, &output);
    gbuffer_destroy(&gbuffer, &host);
    host_close(&host);
    if (host.complaints > 0) fail("the validation layer complained");
    return EXIT_SUCCESS;
}
