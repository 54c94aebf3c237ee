// Whether a light arrives at a point of a face: by the host's shadow map where that covers the point, else by a ray.

#import lib/hdda.wgsl
#import lib/lights.wgsl

@res var<storage, read> shadow_layers: array<ShadowLayer>;
@res var shadow_map_0: texture_2d_array<f32>;
@res var shadow_map_1: texture_2d_array<f32>;
@res var shadow_map_2: texture_2d_array<f32>;
@res var shadow_map_3: texture_2d_array<f32>;

// What a light's shadow map says of a point.
const MAP_SILENT: u32 = 0u;
const MAP_LIT: u32 = 1u;
const MAP_DARK: u32 = 2u;
// Voxels that points of faces may lie behind the surface that the host has drawn: planes are means. Of a ball of 8, 4 and 2
// voxels' radius 7, 23 and 35 % would lie in its own shadow, with .02 voxel .3, .7 and 7, with this none.
const PLANE_ERROR: f32 = 0.05;

fn light_arrives(light: Light, sample: LightSample, p: vec3<f32>, normal: vec3<f32>) -> bool {
    // Another line in the shaders of hosts that have shadow maps (build.rs).
    let said = MAP_SILENT;
    if said != MAP_SILENT { return said == MAP_LIT; }
    return trace(Start(p, normal, FACE_ERROR), sample.direction, sample.reach).kind == MISS;
}

// By the first of the light's layers that covers the point. That is lifted off its face by what the surface may be nearer
// to the light within half a texel, too.
fn ask_map(light: Light, p: vec3<f32>, normal: vec3<f32>) -> u32 {
    if light.kind > LIGHT_SPOT { return MAP_SILENT; }
    let end = u32(light.axis_v.y);
    for (var index = u32(light.axis_v.x); index < end; index++) {
        let layer = shadow_layers[index];
        let on = layer.clip * vec4<f32>(p, 1.0);
        let across = layer.clip * vec4<f32>(normal, 0.0);
        let lift = PLANE_ERROR + layer.normal_offset + max(on.w, 0.0) * dot(abs(across.xy), layer.half_texel);
        let c = on + lift * across;
        let is_inside = all(abs(c.xy) <= vec2<f32>(c.w)) && c.z >= 0.0 && c.z <= c.w && c.w > 0.0;
        if !is_inside { continue; }
        let place = vec2<u32>((c.xy / c.w * 0.5 + 0.5) * vec2<f32>(layer.size));
        let stored = map_texel(layer, layer.corner + min(place, layer.size - 1u));
        var depth = c.z / c.w;
        if layer.distance_scale > 0.0 { depth = distance(light.vector, p + lift * normal) * layer.distance_scale; }
        return select(MAP_DARK, MAP_LIT, (depth - stored) * layer.order <= layer.depth_bias);
    }
    return MAP_SILENT;
}

fn map_texel(layer: ShadowLayer, texel: vec2<u32>) -> f32 {
    switch layer.image {
        case 0u: { return textureLoad(shadow_map_0, texel, layer.layer, 0).x; }
        case 1u: { return textureLoad(shadow_map_1, texel, layer.layer, 0).x; }
        case 2u: { return textureLoad(shadow_map_2, texel, layer.layer, 0).x; }
        default: { return textureLoad(shadow_map_3, texel, layer.layer, 0).x; }
    }
}
