// The faces chosen for lighting: `vis_faces` holds light brick 20 | voxel 9 | side 3.

#import lib/hdda.wgsl
#import lib/random.wgsl
#import shared/bricks.wgsl

@res var<storage, read> light_bricks: array<LightBrick>;
@res var<storage, read> vis_faces: array<u32>;

struct Face {
    voxel: Voxel,
    // Window cell of the voxel.
    cell: vec3<i32>,
    side: u32,
    plane: Plane,
    // Weight of the new value.
    alpha: f32,
    // Stays with the face wherever the window is.
    seed: u32,
}

fn load_face(item: u32) -> Face {
    let brick = light_bricks[item >> 12u];
    let origin = vec3<u32>(brick.position & 1023u, (brick.position >> 10u) & 1023u, brick.position >> 20u) * BRICK_VOXELS;
    let local = (item >> 3u) & 511u;
    let cell = origin + vec3<u32>(local & 7u, (local >> 3u) & 7u, local >> 6u);
    let voxel = brick_voxel(brick.base, world_bricks[brick.base], cell);
    let side = item & 7u;
    let seed = hash3(cell + frame.seed_origin) ^ (side * 0x85ebca6bu);
    return Face(voxel, vec3<i32>(cell), side, voxel_plane(voxel, side), brick.alpha, pcg(seed));
}

// Whether a point (grid space) is in the solid of its voxel or, when it has left `cell`, of the one it is in.
fn point_in_solid(face: Face, p: vec3<f32>) -> bool {
    if inside_solid(face.voxel, p - vec3<f32>(face.cell), face.side) { return true; }
    let cell = vec3<i32>(floor(p));
    if all(cell == face.cell) { return false; }
    let other = find_voxel(cell);
    return other.found && inside_solid(other, p - vec3<f32>(cell), NONE);
}

// A point a little above the face's surface, inside its coverage and outside the solid; grid space. w = 0: none was found
// (what the face covers is hidden in the solid, or nearly so).
fn face_point(face: Face, u: vec2<f32>, seed: u32) -> vec4<f32> {
    let axis = face.side >> 1u;
    let corner = vec3<f32>(face.cell);
    if frame.hit_model == 1u { return vec4<f32>(corner + cube_point(face, u), 1.0); }
    let mask = voxel_mask(face.voxel, face.side);
    var place = u;
    for (var attempt = 0u; attempt < 12u; attempt++) {
        var p = plane_point(face, covered_place(mask, place));
        if p[axis] > -0.01 && p[axis] < 1.01 && !point_in_solid(face, corner + p + face.plane.normal * 0.02) {
            p[axis] = clamp(p[axis], 0.0, 1.0);
            return vec4<f32>(corner + p + face.plane.normal * 0.002, 1.0);
        }
        place = r2(seed, attempt);
    }
    return vec4<f32>(0.0);
}

// Maps the unit square to the set cells of a coverage mask, evenly.
fn covered_place(mask: u32, u: vec2<f32>) -> vec2<f32> {
    if mask == 0xffffu || mask == 0u { return u; }
    let count = f32(countOneBits(mask));
    let pick = u.x * count;
    var rest = mask;
    for (var skip = u32(pick); skip > 0u; skip--) { rest &= rest - 1u; }
    let bit = firstTrailingBit(rest);
    return (vec2<f32>(f32(bit & 3u), f32(bit >> 2u)) + vec2<f32>(fract(pick), u.y)) * 0.25;
}

fn plane_point(face: Face, u: vec2<f32>) -> vec3<f32> {
    let axis = face.side >> 1u;
    var p = vec3<f32>(0.0);
    p[axis_u(axis)] = u.x;
    p[axis_v(axis)] = u.y;
    p[axis] = (face.plane.offset - dot(face.plane.normal, p)) / face.plane.normal[axis];
    return p;
}

fn cube_point(face: Face, u: vec2<f32>) -> vec3<f32> {
    let axis = face.side >> 1u;
    var p = vec3<f32>(0.0);
    p[axis_u(axis)] = u.x;
    p[axis_v(axis)] = u.y;
    p[axis] = f32(face.side & 1u);
    return p + 0.001 * side_normal(face.side);
}

// The normal that a face is lit with.
fn face_normal(face: Face) -> vec3<f32> {
    if frame.hit_model == 1u { return side_normal(face.side); }
    return face.plane.normal;
}

// Irradiance on its way between the lighting passes; INVALID in the second word: no point of the face could be lit.
const INVALID: u32 = 0xffffffffu;

fn pack_irradiance(e: vec3<f32>) -> vec2<u32> {
    let c = min(e, vec3<f32>(65000.0));
    return vec2<u32>(pack2x16float(c.xy), pack2x16float(vec2<f32>(c.z, 0.0)));
}

fn unpack_irradiance(words: vec2<u32>) -> vec3<f32> {
    return vec3<f32>(unpack2x16float(words.x), unpack2x16float(words.y).x);
}
