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

// Whether a side's plane and that of the opposite side are the two sides of a sheet.
fn is_sheet(v: Voxel, side: u32, plane: Plane) -> bool {
    if !has_side(v, side ^ 1u) { return false; }
    let back = voxel_plane(v, side ^ 1u);
    return dot(back.normal, plane.normal) < -0.98 && abs(back.offset + plane.offset) < 0.05;
}

// Whether p, on one side of a sheet and in a set cell, lies beyond the edge at which the sheet bends away: cells are
// coarser than surfaces, and what sticks out would shade the surface that the sheet goes on as, where the ray starts.
fn is_beyond_edge(v: Voxel, side: u32, plane: Plane, p: vec3<f32>, start: vec3<f32>) -> bool {
    let mask = voxel_mask(v, side);
    if mask == 0xffffu || !is_sheet(v, side, plane) { return false; }
    let middle = on_plane(plane, side >> 1u, mask_middle(mask));
    for (var other = 0u; other < 6u; other++) {
        if (other >> 1u) == (side >> 1u) || !has_side(v, other) { continue; }
        let edge = voxel_plane(v, other);
        if dot(edge.normal, p) - edge.offset < 0.002 || dot(edge.normal, middle) > edge.offset
            || dot(edge.normal, start) <= edge.offset || !is_sheet(v, other, edge) { continue; }
        // Half a coverage cell off the plane: its own cell may be the first that the other side leaves open.
        if covers(v, other, p) || covers(v, other, p + 0.12 * plane.normal) { return true; }
    }
    return false;
}

// Mean place of a mask's set cells.
fn mask_middle(mask: u32) -> vec2<f32> {
    var sum = vec2<f32>(0.0);
    for (var k = 0u; k < 4u; k++) {
        let columns = f32(countOneBits(mask & (0x1111u << k)));
        let rows = f32(countOneBits(mask & (0xfu << (4u * k))));
        sum += vec2<f32>(columns, rows) * (f32(k) + 0.5);
    }
    return sum * 0.25 / f32(max(countOneBits(mask), 1u));
}

// The point of an axis's plane at a place of the voxel's cross-section.
fn on_plane(plane: Plane, axis: u32, place: vec2<f32>) -> vec3<f32> {
    var p = vec3<f32>(0.0);
    p[axis_u(axis)] = place.x;
    p[axis_v(axis)] = place.y;
    p[axis] = (plane.offset - dot(plane.normal, p)) / plane.normal[axis];
    return p;
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
    return vec3<f32>(cell) + clamp(on_plane(plane, axis, vec2<f32>(0.5)), vec3<f32>(0.0), vec3<f32>(1.0));
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
