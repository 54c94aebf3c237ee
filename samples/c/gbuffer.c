#include "gbuffer.h"

#include "gbuffer_spirv.h"

#include <math.h>
#include <stddef.h>

typedef struct Vertex {
    float position[3], normal[3];
} Vertex;

/* The layout of `Camera` in gbuffer.wgsl. */
typedef struct Constants {
    float clip_from_relative[4][4];
    float eye[3];
} Constants;

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void cross(const double a[3], const double b[3], double out[3]) {
    for (int i = 0; i < 3; i++) out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static void normalise(double v[3]) {
    const double length = sqrt(dot(v, v));
    for (int i = 0; i < 3; i++) v[i] /= length;
}

Camera camera_of(const CornellCamera *from, uint32_t width, uint32_t height) {
    Camera camera = {.projection = {{0}}};
    double forward[3], right[3], up[3];
    for (int i = 0; i < 3; i++) forward[i] = from->target[i] - from->position[i];
    normalise(forward);
    cross(forward, from->up, right);
    normalise(right);
    cross(right, forward, up);
    for (int i = 0; i < 3; i++) {
        camera.position[i] = from->position[i];
        camera.view_rotation[i][0] = (float)right[i];
        camera.view_rotation[i][1] = (float)up[i];
        camera.view_rotation[i][2] = (float)-forward[i];
    }
    const double degree = 0.017453292519943295;
    const double half_height = tan(0.5 * from->vertical_fov * degree);
    camera.projection[0][0] = (float)(height / (half_height * width));
    camera.projection[1][1] = (float)(-1.0 / half_height);
    camera.projection[2][3] = -1.0f;
    camera.projection[3][2] = (float)from->near_plane;
    return camera;
}

/* Every triangle gets its own three vertices, so that the normal is exactly its face's. */
static void write_vertices(Vertex *vertices) {
    for (uint32_t p = 0; p < CORNELL_PARTS; p++) {
        const CornellPart *part = &cornell_parts[p];
        for (uint32_t i = part->first_index; i < part->first_index + part->index_count; i += 3) {
            const float *corner[3];
            double edge[2][3], normal[3];
            for (int k = 0; k < 3; k++) corner[k] = cornell_positions[part->first_vertex + cornell_indices[i + k]];
            for (int k = 0; k < 3; k++) {
                edge[0][k] = (double)corner[1][k] - corner[0][k];
                edge[1][k] = (double)corner[2][k] - corner[0][k];
            }
            cross(edge[0], edge[1], normal);
            normalise(normal);
            for (int k = 0; k < 9; k++) {
                vertices[i + k / 3].position[k % 3] = corner[k / 3][k % 3];
                vertices[i + k / 3].normal[k % 3] = (float)normal[k % 3];
            }
        }
    }
}

static void create_pass(Gbuffer *gbuffer, const Host *host) {
    const VkAttachmentDescription attachments[2] = {
        {
            .format = VK_FORMAT_R16G16B16A16_SFLOAT,
            .samples = VK_SAMPLE_COUNT_1_BIT,
            .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
            .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
            .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
            .finalLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
        },
        {
            .format = VK_FORMAT_D32_SFLOAT,
            .samples = VK_SAMPLE_COUNT_1_BIT,
            .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
            .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
            .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
            .finalLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
        },
    };
    const VkAttachmentReference color = {0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
    const VkAttachmentReference depth = {1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
    const VkSubpassDescription subpass = {
        .pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS,
        .colorAttachmentCount = 1,
        .pColorAttachments = &color,
        .pDepthStencilAttachment = &depth,
    };
    const VkPipelineStageFlags drawing = VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT |
                                         VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT |
                                         VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT;
    const VkAccessFlags written =
        VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
    const VkSubpassDependency dependencies[2] = {
        /* The last frame's compute shaders have read the images, and its drawing has written them. */
        {
            .srcSubpass = VK_SUBPASS_EXTERNAL,
            .srcStageMask = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | drawing,
            .dstStageMask = drawing,
            .srcAccessMask = written,
            .dstAccessMask = written | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT,
        },
        /* This frame's compute shaders will read them: what the library asks of its inputs. */
        {
            .dstSubpass = VK_SUBPASS_EXTERNAL,
            .srcStageMask = drawing,
            .dstStageMask = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
            .srcAccessMask = written,
            .dstAccessMask = VK_ACCESS_SHADER_READ_BIT,
        },
    };
    const VkRenderPassCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
        .attachmentCount = 2,
        .pAttachments = attachments,
        .subpassCount = 1,
        .pSubpasses = &subpass,
        .dependencyCount = 2,
        .pDependencies = dependencies,
    };
    require(vkCreateRenderPass(host->device, &info, NULL, &gbuffer->pass), "vkCreateRenderPass");
    const VkImageView views[2] = {gbuffer->normal.view, gbuffer->depth.view};
    const VkFramebufferCreateInfo framebuffer = {
        .sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
        .renderPass = gbuffer->pass,
        .attachmentCount = 2,
        .pAttachments = views,
        .width = gbuffer->width,
        .height = gbuffer->height,
        .layers = 1,
    };
    require(vkCreateFramebuffer(host->device, &framebuffer, NULL, &gbuffer->framebuffer), "vkCreateFramebuffer");
}

static void create_pipeline(Gbuffer *gbuffer, const Host *host) {
    const VkPushConstantRange range = {VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof(Constants)};
    const VkPipelineLayoutCreateInfo layout = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
        .pushConstantRangeCount = 1,
        .pPushConstantRanges = &range,
    };
    require(vkCreatePipelineLayout(host->device, &layout, NULL, &gbuffer->layout), "vkCreatePipelineLayout");
    const VkShaderModuleCreateInfo code = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
        .codeSize = sizeof gbuffer_spirv,
        .pCode = gbuffer_spirv,
    };
    VkShaderModule module;
    require(vkCreateShaderModule(host->device, &code, NULL, &module), "vkCreateShaderModule");
    VkPipelineShaderStageCreateInfo stages[2] = {
        {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, .module = module, .pName = "vertex_main"},
        {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, .module = module, .pName = "fragment_main"},
    };
    stages[0].stage = VK_SHADER_STAGE_VERTEX_BIT;
    stages[1].stage = VK_SHADER_STAGE_FRAGMENT_BIT;
    const VkVertexInputBindingDescription binding = {0, sizeof(Vertex), VK_VERTEX_INPUT_RATE_VERTEX};
    const VkVertexInputAttributeDescription attributes[2] = {
        {0, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(Vertex, position)},
        {1, 0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(Vertex, normal)},
    };
    const VkPipelineVertexInputStateCreateInfo input = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
        .vertexBindingDescriptionCount = 1,
        .pVertexBindingDescriptions = &binding,
        .vertexAttributeDescriptionCount = 2,
        .pVertexAttributeDescriptions = attributes,
    };
    const VkPipelineInputAssemblyStateCreateInfo assembly = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
    };
    const VkViewport viewport = {0.0f, 0.0f, (float)gbuffer->width, (float)gbuffer->height, 0.0f, 1.0f};
    const VkRect2D scissor = {{0, 0}, {gbuffer->width, gbuffer->height}};
    const VkPipelineViewportStateCreateInfo region = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
        .viewportCount = 1,
        .pViewports = &viewport,
        .scissorCount = 1,
        .pScissors = &scissor,
    };
    const VkPipelineRasterizationStateCreateInfo raster = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
        .lineWidth = 1.0f,
    };
    const VkPipelineMultisampleStateCreateInfo samples = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
        .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT,
    };
    const VkPipelineDepthStencilStateCreateInfo depth = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
        .depthTestEnable = VK_TRUE,
        .depthWriteEnable = VK_TRUE,
        .depthCompareOp = VK_COMPARE_OP_GREATER,
    };
    const VkPipelineColorBlendAttachmentState channels = {.colorWriteMask = 0xf};
    const VkPipelineColorBlendStateCreateInfo blend = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
        .attachmentCount = 1,
        .pAttachments = &channels,
    };
    const VkGraphicsPipelineCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
        .stageCount = 2,
        .pStages = stages,
        .pVertexInputState = &input,
        .pInputAssemblyState = &assembly,
        .pViewportState = &region,
        .pRasterizationState = &raster,
        .pMultisampleState = &samples,
        .pDepthStencilState = &depth,
        .pColorBlendState = &blend,
        .layout = gbuffer->layout,
        .renderPass = gbuffer->pass,
    };
    require(vkCreateGraphicsPipelines(host->device, VK_NULL_HANDLE, 1, &info, NULL, &gbuffer->pipeline),
            "vkCreateGraphicsPipelines");
    vkDestroyShaderModule(host->device, module, NULL);
}

void gbuffer_create(Gbuffer *gbuffer, const Host *host, uint32_t width, uint32_t height) {
    gbuffer->width = width;
    gbuffer->height = height;
    gbuffer->depth =
        host_image(host, VK_FORMAT_D32_SFLOAT, VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
                   VK_IMAGE_ASPECT_DEPTH_BIT, width, height);
    gbuffer->normal =
        host_image(host, VK_FORMAT_R16G16B16A16_SFLOAT, VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT,
                   VK_IMAGE_ASPECT_COLOR_BIT, width, height);
    create_pass(gbuffer, host);
    create_pipeline(gbuffer, host);
    gbuffer->vertices = host_buffer(host, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT, CORNELL_INDICES * sizeof(Vertex));
    write_vertices(gbuffer->vertices.data);
}

void gbuffer_draw(const Gbuffer *gbuffer, VkCommandBuffer commands, const Camera *camera) {
    Constants constants = {.clip_from_relative = {{0}}};
    for (int column = 0; column < 4; column++) {
        for (int row = 0; row < 4; row++) {
            double sum = column == 3 ? camera->projection[3][row] : 0.0;
            for (int k = 0; k < 3 && column < 3; k++)
                sum += (double)camera->projection[k][row] * camera->view_rotation[column][k];
            constants.clip_from_relative[column][row] = (float)sum;
        }
    }
    for (int i = 0; i < 3; i++) constants.eye[i] = (float)camera->position[i];

    const VkClearValue clear[2] = {{.color = {{0}}}, {.depthStencil = {0.0f, 0}}};
    const VkRenderPassBeginInfo begin = {
        .sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
        .renderPass = gbuffer->pass,
        .framebuffer = gbuffer->framebuffer,
        .renderArea = {{0, 0}, {gbuffer->width, gbuffer->height}},
        .clearValueCount = 2,
        .pClearValues = clear,
    };
    const VkDeviceSize offset = 0;
    vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, gbuffer->pipeline);
    vkCmdPushConstants(commands, gbuffer->layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof constants, &constants);
    vkCmdBindVertexBuffers(commands, 0, 1, &gbuffer->vertices.buffer, &offset);
    vkCmdDraw(commands, CORNELL_INDICES, 1, 0, 0);
    vkCmdEndRenderPass(commands);
}

void gbuffer_destroy(Gbuffer *gbuffer, const Host *host) {
    vkDestroyPipeline(host->device, gbuffer->pipeline, NULL);
    vkDestroyPipelineLayout(host->device, gbuffer->layout, NULL);
    vkDestroyFramebuffer(host->device, gbuffer->framebuffer, NULL);
    vkDestroyRenderPass(host->device, gbuffer->pass, NULL);
    host_free_buffer(host, &gbuffer->vertices);
    host_free_image(host, &gbuffer->normal);
    host_free_image(host, &gbuffer->depth);
}
