/* The host's G-buffer of the Cornell box: depth and world normal, rasterised by one small pipeline. */
#ifndef GBUFFER_H
#define GBUFFER_H

#include "cornell_mesh.h"
#include "host.h"

/* A camera in the host's own terms; matrices are [column][row]. */
typedef struct Camera {
    double position[3];
    float view_rotation[3][3]; /* world to view: x right, y up, z backwards */
    float projection[4][4];    /* infinite, reversed depth: 1 at the near plane, 0 far away; y down */
} Camera;

typedef struct Gbuffer {
    Image depth;  /* VK_FORMAT_D32_SFLOAT, cleared to 0 */
    Image normal; /* VK_FORMAT_R16G16B16A16_SFLOAT */
    uint32_t width, height;
    VkRenderPass pass;
    VkFramebuffer framebuffer;
    VkPipelineLayout layout;
    VkPipeline pipeline;
    Buffer vertices;
} Gbuffer;

Camera camera_of(const CornellCamera *camera, uint32_t width, uint32_t height);

void gbuffer_create(Gbuffer *gbuffer, const Host *host, uint32_t width, uint32_t height);
/* Records drawing. Afterwards both images are SHADER_READ_ONLY_OPTIMAL and visible to compute shaders. */
void gbuffer_draw(const Gbuffer *gbuffer, VkCommandBuffer commands, const Camera *camera);
void gbuffer_destroy(Gbuffer *gbuffer, const Host *host);

#endif
