// Points and lights on the surfaces that a voxel holds. Points are in the voxel's unit cube unless said otherwise.

// Whether p lies in the solid: behind a covered plane and not in front of that plane's covered opposite (a thin wall).
fn inside_solid(v: Voxel, p: vec3<f32>, skip: u32) -> bool {
    for (var side = 0u; side < 6u; side++) {
        if side == skip || !has_side(v, side) { continue; }
        let plane = voxel_plane(v, side);
        if dot(plane.normal, p) - plane.offset >= -0.01 || !covers(v, side, p) { continue; }
        if !before_opposite(v, side, p) { return true; }
    }
    return false;
}

// Whether p is in front of the covered opposite of a side: beyond a thin wall or sheet, not in a solid.
fn before_opposite(v: Voxel, side: u32, p: vec3<f32>) -> bool {
    let other = side ^ 1u;
    if !has_side(v, other) { return false; }
    let back = voxel_plane(v, other);
    return dot(back.normal, p) > back.offset && covers(v, other, p);
}

// Whether a wall of `v` (not of axis `axis`) stands between a and b, both in grid space.
fn separated(v: Voxel, cell: vec3<i32>, axis: u32, a: vec3<f32>, b: vec3<f32>) -> bool {
    for (var side = 0u; side < 6u; side++) {
        if (side >> 1u) == axis || !has_side(v, side) { continue; }
        let plane = voxel_plane(v, side);
        let da = dot(plane.normal, a - vec3<f32>(cell)) - plane.offset;
        let db = dot(plane.normal, b - vec3<f32>(cell)) - plane.offset;
        if da * db < -1e-4 { return true; }
    }
    return false;
}

// Where a face's plane stands at the middle of its voxel, grid space.
fn plane_middle(plane: Plane, cell: vec3<i32>, axis: u32) -> vec3<f32> {
    var p = vec3<f32>(0.5);
    p[axis] = 0.0;
    p[axis] = clamp((plane.offset - dot(plane.normal, p)) / plane.normal[axis], 0.0, 1.0);
    return vec3<f32>(cell) + p;
}

// Radiance for a hit at `hit` (grid space) on a closed, unlit face: of the nearest in-plane neighbour of the same
// direction, else of the voxel in front, else of an own face that has the point in front, else black (NONE).
// accuracy rule 3 and "Lighting".
fn closed_face_light(v: Voxel, cell: vec3<i32>, side: u32, plane: Plane, hit: vec3<f32>, direction: vec3<f32>) -> u32 {
    let axis = side >> 1u;
    let front_cell = cell + vec3<i32>(side_normal(side));
    let front = find_voxel(front_cell);
    if front.found {
        let lifted = hit + plane.normal * 0.05;
        let local = lifted - vec3<f32>(cell);
        var best = NONE;
        var best_distance = 1e9;
        for (var e = 0u; e < 6u; e++) {
            if (e >> 1u) == axis { continue; }
            let distance = select(local[e >> 1u], 1.0 - local[e >> 1u], (e & 1u) == 1u);
            if distance >= best_distance { continue; }
            let near_cell = cell + vec3<i32>(side_normal(e));
            let near = find_voxel(near_cell);
            if !near.found || !is_lit(near, side) || !has_side(near, side) { continue; }
            let near_plane = voxel_plane(near, side);
            let height = dot(near_plane.normal, hit - vec3<f32>(near_cell)) - near_plane.offset;
            if dot(near_plane.normal, plane.normal) < 0.7 || abs(height) > 0.25 { continue; }
            let target_point = plane_middle(near_plane, near_cell, axis) + near_plane.normal * 0.05;
            if separated(v, cell, axis, lifted, target_point) || separated(front, front_cell, axis, lifted, target_point) {
                continue;
            }
            best = light_address(near, side);
            best_distance = distance;
        }
        if best != NONE { return best; }
        if is_lit(front, side) && has_side(front, side) {
            let front_plane = voxel_plane(front, side);
            if abs(dot(front_plane.normal, hit - vec3<f32>(front_cell)) - front_plane.offset) < 0.25 {
                return light_address(front, side);
            }
        }
    }
    var best = NONE;
    var best_cosine = 0.0;
    for (var k = 0u; k < 6u; k++) {
        if !is_lit(v, k) || !has_side(v, k) { continue; }
        let own = voxel_plane(v, k);
        let cosine = -dot(own.normal, direction);
        if dot(own.normal, hit - vec3<f32>(cell)) - own.offset < -0.1 || cosine <= best_cosine { continue; }
        best = light_address(v, k);
        best_cosine = cosine;
    }
    return best;
}
