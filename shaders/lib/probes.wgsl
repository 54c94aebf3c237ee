// Screen probes: one a tile, and in a second layer one more where that does not stand for all of it, on a pixel's surface,
// with an 8 x 8 hemi-octahedral map of radiance about its normal.

#import shared/view.wgsl
#import lib/random.wgsl
#import lib/world.wgsl

@res var<uniform> view: View;
@res var depth_image: texture_2d<f32>;
@res var normal_image: texture_2d<f32>;
// Any image where the host gives none.
@res var motion_image: texture_2d<f32>;

fn luminance(color: vec3<f32>) -> f32 {
    return dot(color, vec3<f32>(0.2126, 0.7152, 0.0722));
}

fn probe_index(tile: vec2<u32>, layer: u32) -> u32 {
    return (layer * view.tiles.y + tile.y) * view.tiles.x + tile.x;
}

// Where the cells of a level of mips begin in `probes`: each names, in its four quarters, the probe of one tile, counted from
// one. Those of level 1 are two tiles wide.
fn mip_start(level: u32) -> u32 {
    var start = 2u * PROBE_LAYERS * view.tiles.x * view.tiles.y;
    for (var below = 1u; below < level; below++) {
        let cells = mip_cells(below);
        start += cells.x * cells.y;
    }
    return start;
}

fn mip_cells(level: u32) -> vec2<u32> {
    return (view.tiles + (1u << level) - 1u) >> vec2<u32>(level);
}

// Tiles that the last frame had.
fn previous_tiles() -> vec2<u32> {
    let size = vec2<u32>(view.previous_size & 0xffffu, view.previous_size >> 16u);
    return (size + view.tile_size - 1u) / view.tile_size;
}

// A pixel's surface.
struct Surface {
    valid: bool,
    // Relative to the camera, metres.
    position: vec3<f32>,
    normal: vec3<f32>,
}

// Where a pixel of this depth is, relative to the camera, metres.
fn pixel_position(pixel: vec2<u32>, depth: f32) -> vec3<f32> {
    let ndc = (vec2<f32>(pixel) + 0.5) / vec2<f32>(view.size) * 2.0 - 1.0;
    let p = view.clip_to_view * vec4<f32>(ndc, depth, 1.0);
    return (view.view_to_world * vec4<f32>(p.xyz / p.w, 0.0)).xyz;
}

// Where a pixel's surface was in the last frame less where it is now, by the host's motion: parts of the image.
fn motion_of(pixel: vec2<u32>) -> vec2<f32> {
    return textureLoad(motion_image, view.origin + pixel, 0).xy * view.motion_scale + view.motion_shift;
}

fn load_surface(pixel: vec2<u32>) -> Surface {
    let depth = textureLoad(depth_image, view.origin + pixel, 0).x;
    if depth == view.clear_depth { return Surface(); }
    let position = pixel_position(pixel, depth);
    let n = textureLoad(normal_image, view.origin + pixel, 0).xyz;
    let length2 = dot(n, n);
    if !(length2 > 1e-6) || !(dot(position, position) < 1e12) { return Surface(); }
    return Surface(true, position, n * inverseSqrt(length2));
}

// How much of the light at another surface is to be expected at this one, `distance` from the camera: 0 to 1, by the
// distance of each to the other's plane and by normals.
fn likeness(surface: Surface, other: Surface, distance: f32) -> f32 {
    let between = other.position - surface.position;
    let off_plane = max(abs(dot(between, surface.normal)), abs(dot(between, other.normal)));
    let relative = off_plane / (0.02 * distance + 0.05 * frame.voxel_size);
    let facing = dot(other.normal, surface.normal);
    return select(exp2(-relative * relative) * pow(facing, 8.0), 0.0, facing < 0.5);
}

// Where there is no surface.
const NO_SURFACE: u32 = 0u;
// Cosine of the angle by which normals of the same surface may differ from frame to frame.
const SAME_FACING: f32 = 0.8;
// How far apart, over the distance to the camera, planes and distances of the same surface may be.
const SAME_PLANE: f32 = 0.02;

// What a pixel's history says of its surface: distance to the camera as half, two bytes of normal (octahedral: Cigolle et
// al., A Survey of Efficient Representations for Independent Unit Vectors, JCGT 2014).
fn surface_word(surface: Surface) -> u32 {
    let n = surface.normal;
    let p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    let folded = (1.0 - abs(p.yx)) * select(vec2<f32>(-1.0), vec2<f32>(1.0), p >= vec2<f32>(0.0));
    let bytes = pack4x8snorm(vec4<f32>(0.0, 0.0, select(folded, p, n.z >= 0.0)));
    let distance = clamp(length(surface.position), 1e-4, 65000.0);
    return (pack2x16float(vec2<f32>(distance, 0.0)) & 0xffffu) | (bytes & 0xffff0000u);
}

// Where a pixel's surface was in the last frame.
struct Before {
    in_view: bool,
    // In pixels of that frame; the middle of the first one is at 0.5.
    place: vec2<f32>,
    // From that frame's camera, and how far off this may be, for motion says nothing of it: metres.
    distance: f32,
    slack: f32,
    // How far it has moved across the image by itself, metres.
    travelled: f32,
}

// By camera and depth, as if it had stood still, and where the host gives motion by that.
fn surface_before(surface: Surface, pixel: vec2<u32>) -> Before {
    let clip = view.previous_clip * vec4<f32>(surface.position, 1.0);
    let size = vec2<f32>(vec2<u32>(view.previous_size & 0xffffu, view.previous_size >> 16u));
    let still = (clip.xy / clip.w * 0.5 + 0.5) * size;
    let motion = motion_of(pixel);
    let moved = ((vec2<f32>(pixel) + 0.5) / vec2<f32>(view.size) + motion) * size;
    var before = Before(clip.w > 0.0, still, length(surface.position - view.camera_delta), 0.0, 0.0);
    if at_run_time(view.has_motion, bitcast<u32>(abs(surface.position.x))) == 1u {
        let apart = (moved - still) / size * vec2<f32>(view.size);
        // Halves err by a thousandth.
        let by_itself = length(apart) - 0.05 - length(motion * vec2<f32>(view.size)) / 500.0;
        before.place = moved;
        // Of what is not a number, too.
        before.in_view &= all(abs(moved) < vec2<f32>(1e5));
        if by_itself > 0.0 {
            // It may have kept to the camera, or to the world, or have come nearer while it went aside.
            let beside = length(surface.position);
            before.travelled = by_itself * view.pixel_width * clip.w;
            before.slack = 0.5 * abs(before.distance - beside) + before.travelled;
            before.distance = 0.5 * (before.distance + beside);
        }
    }
    return before;
}

// Whether a pixel with such a history has seen a surface of this normal, `distance` from the camera of its frame.
fn is_same_surface(word: u32, normal: vec3<f32>, distance: f32, slack: f32) -> bool {
    if word == NO_SURFACE { return false; }
    let seen = unpack2x16float(word).x;
    let p = unpack4x8snorm(word).zw;
    let z = 1.0 - abs(p.x) - abs(p.y);
    let folded = p - max(-z, 0.0) * select(vec2<f32>(-1.0), vec2<f32>(1.0), p >= vec2<f32>(0.0));
    let was = vec3<f32>(folded, z);
    return abs(seen - distance) <= SAME_PLANE * distance + 1e-3 + slack && dot(was, normal) >= SAME_FACING * length(was);
}

// Unit square to the hemisphere about +z, and the solid angle per unit of the square's area (mean: 2 pi).
fn hemi_octahedral(square: vec2<f32>) -> vec4<f32> {
    let s = square * 2.0 - 1.0;
    let x = (s.x + s.y) * 0.5;
    let y = (s.x - s.y) * 0.5;
    let v = vec3<f32>(x, y, 1.0 - abs(x) - abs(y));
    let length2 = dot(v, v);
    // The octahedron's faces are 1/sqrt(3) from the centre; d(x, y) = 2 d(square).
    return vec4<f32>(v * inverseSqrt(length2), 2.0 / (length2 * sqrt(length2)));
}

// Direction about +z (z >= 0) to the unit square.
fn hemi_square(v: vec3<f32>) -> vec2<f32> {
    let p = v.xy / max(abs(v.x) + abs(v.y) + max(v.z, 0.0), 1e-6);
    return clamp(vec2<f32>(p.x + p.y, p.x - p.y) * 0.5 + 0.5, vec2<f32>(0.0), vec2<f32>(1.0));
}
