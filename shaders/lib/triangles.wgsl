// The triangles of queued bricks.

#import shared/limits.wgsl
#import shared/bricks.wgsl
#import lib/pack.wgsl

@res var<storage, read> batch_bricks: array<BatchBrick>;
// The bricks' lists: indices of triangles, which bricks of a group share.
@res var<storage, read> triangle_lists: array<u32>;
// In group space: voxels, origin at the group's low corner.
@res var<storage, read> triangles: array<vec4<f32>>;

struct Triangle {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    material: u32,
}

// Low corner of a brick in its group.
fn place_in_group(brick: BatchBrick) -> vec3<f32> {
    return vec3<f32>(vec3<u32>(brick.place & 3u, (brick.place >> 2u) & 3u, brick.place >> 4u) * BRICK_VOXELS);
}

// A triangle of a list, moved so that `origin` (group space) is zero.
fn load_triangle(entry: u32, origin: vec3<f32>) -> Triangle {
    let first = triangle_lists[entry] * 4u;
    let a = triangles[first];
    return Triangle(a.xyz - origin, triangles[first + 1u].xyz - origin, triangles[first + 2u].xyz - origin,
                    bitcast<u32>(a.w));
}

fn triangle_normal(t: Triangle) -> vec3<f32> {
    return normalize(cross(t.b - t.a, t.c - t.a));
}

fn separated_by(axis: vec3<f32>, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, half_size: f32) -> bool {
    let pa = dot(axis, a);
    let pb = dot(axis, b);
    let pc = dot(axis, c);
    let reach = half_size * (abs(axis.x) + abs(axis.y) + abs(axis.z));
    return min(min(pa, pb), pc) > reach || max(max(pa, pb), pc) < -reach;
}

// Separating axes of a triangle and a cube about `center` (Akenine-Moller, Fast 3D Triangle-Box Overlap, 2001).
fn overlaps_cube(t: Triangle, center: vec3<f32>, half_size: f32) -> bool {
    let a = t.a - center;
    let b = t.b - center;
    let c = t.c - center;
    let low = min(min(a, b), c);
    let high = max(max(a, b), c);
    if any(low > vec3<f32>(half_size)) || any(high < vec3<f32>(-half_size)) { return false; }
    let ab = b - a;
    let bc = c - b;
    let ca = a - c;
    let normal = cross(ab, bc);
    if abs(dot(normal, a)) > half_size * (abs(normal.x) + abs(normal.y) + abs(normal.z)) { return false; }
    return !(separated_by(vec3<f32>(0.0, -ab.z, ab.y), a, b, c, half_size)
        || separated_by(vec3<f32>(0.0, -bc.z, bc.y), a, b, c, half_size)
        || separated_by(vec3<f32>(0.0, -ca.z, ca.y), a, b, c, half_size)
        || separated_by(vec3<f32>(ab.z, 0.0, -ab.x), a, b, c, half_size)
        || separated_by(vec3<f32>(bc.z, 0.0, -bc.x), a, b, c, half_size)
        || separated_by(vec3<f32>(ca.z, 0.0, -ca.x), a, b, c, half_size)
        || separated_by(vec3<f32>(-ab.y, ab.x, 0.0), a, b, c, half_size)
        || separated_by(vec3<f32>(-bc.y, bc.x, 0.0), a, b, c, half_size)
        || separated_by(vec3<f32>(-ca.y, ca.x, 0.0), a, b, c, half_size));
}

// Cell of the apron grid: -1 to 8 per axis.
fn apron_cell(index: u32) -> vec3<i32> {
    return vec3<i32>(vec3<u32>(index % 10u, (index / 10u) % 10u, index / 100u)) - 1;
}

fn apron_index(cell: vec3<i32>) -> u32 {
    let c = vec3<u32>(cell + 1);
    return c.x + APRON_VOXELS * (c.y + APRON_VOXELS * c.z);
}
