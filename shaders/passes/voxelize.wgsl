// One listed voxel a workgroup: 16 x 16 columns along each axis, four in a row a thread, are cut against the triangles; the
// outermost layer of each column enters the face's sums. Then planes, coverage and what the voxel shows its neighbours.
// Per-face sums weighted by projected area are what rasterising in three directions would give, without its overdraw;
// they are integers, so their order does not matter. Rules: accuracy "Build, per voxel".

#import lib/triangles.wgsl
#import lib/random.wgsl

struct VoxelizePush {
    first_brick: u32,
    emission_max: f32,
}
var<immediate> push: VoxelizePush;

@res var<storage, read> voxel_items: array<u32>;
@res var<storage, read> materials: array<Material>;
@res var<storage, read> texels: array<u32>;
@res var<storage, read_write> voxel_states: array<u32>;
@res var<storage, read_write> voxel_records: array<u32>;

const LIST_MAX: u32 = 512u;
const CONTACT: u32 = 0x80000000u;
const CONTACT_LIST_MAX: u32 = 256u;
const SUMS: u32 = 13u;
// Voxels: what is thinner has edges that coverage cells are too coarse for.
const EDGE_MAX: f32 = 0.375;
const FIXED: f32 = 1048576.0;

// Triangles that touch the voxel: index in the brick | CONTACT.
var<workgroup> list: array<u32, 512>;
var<workgroup> list_count: atomic<u32>;
// What every thread reads of it.
var<workgroup> list_size: u32;
// Triangles flagged CONTACT.
var<workgroup> contacts: array<u32, 256>;
var<workgroup> contact_count: atomic<u32>;
// Sides that a column of any thread has a crossing for, and those of them that do not fill the cross-section: 6 bits.
var<workgroup> present: atomic<u32>;
var<workgroup> present_sides: u32;
var<workgroup> unfilled: atomic<u32>;
var<workgroup> unfilled_sides: u32;
// Per side: samples, normal, position, albedo, emission.
var<workgroup> sums: array<atomic<i32>, 78>;
var<workgroup> coverage: array<atomic<u32>, 48>;
// Per side and coverage cell: covered | open << 16.
var<workgroup> cells: array<atomic<u32>, 96>;
var<workgroup> planes: array<vec4<f32>, 6>;
// Per side: coverage mask | columns it stands for << 16.
var<workgroup> masks: array<u32, 6>;
// 1: not every side is wholly covered.
var<workgroup> part_filled: atomic<u32>;
// 1: a triangle that crosses columns here lets light through.
var<workgroup> translucent: atomic<u32>;

// Outermost crossings of the thread's columns, a side each: height | triangle, larger is further out; 0: none.
struct Crossings {
    low_x: vec4<u32>,
    high_x: vec4<u32>,
    low_y: vec4<u32>,
    high_y: vec4<u32>,
    low_z: vec4<u32>,
    high_z: vec4<u32>,
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let item = voxel_items[group.x];
    let batch = item >> 10u;
    let brick = batch_bricks[push.first_brick + batch];
    let cell = apron_cell(item & 1023u);
    let origin = place_in_group(brick) + vec3<f32>(cell);

    for (var i = thread; i < 78u; i += 64u) { atomicStore(&sums[i], 0); }
    for (var i = thread; i < 96u; i += 64u) { atomicStore(&cells[i], 0u); }
    if thread < 48u { atomicStore(&coverage[thread], 0u); }
    if thread == 0u {
        atomicStore(&present, 0u);
        atomicStore(&unfilled, 0u);
        atomicStore(&part_filled, 0u);
        atomicStore(&translucent, 0u);
    }

    var crossings = Crossings();
    var next = 0u;
    var rounds = 0u;
    while next < brick.triangle_count {
        if thread == 0u {
            atomicStore(&list_count, 0u);
            atomicStore(&contact_count, 0u);
        }
        workgroupBarrier();
        // Gather until the list may overflow; further triangles come in another round.
        while next < brick.triangle_count && published_count(thread) <= LIST_MAX - 64u {
            let i = next + thread;
            if i < brick.triangle_count
                && overlaps_cube(load_triangle(brick.first_triangle + i, origin), vec3<f32>(0.5), 0.51) {
                list[atomicAdd(&list_count, 1u)] = i;
            }
            next += 64u;
            workgroupBarrier();
        }
        let count = published_count(thread);
        // Solids touch in few, large triangles: a crowded voxel is not searched, which bounds the cost of a dense mesh.
        if count <= CONTACT_LIST_MAX && next >= brick.triangle_count && rounds == 0u {
            flag_contacts(brick.first_triangle, origin, count, thread);
        }
        rounds++;
        workgroupBarrier();
        for (var k = 0u; k < count; k++) { cut(brick.first_triangle, origin, list[k], thread, &crossings); }
        workgroupBarrier();
    }
    atomicOr(&present, crossed_sides(crossings));
    workgroupBarrier();
    if thread == 0u { present_sides = atomicLoad(&present); }
    let sides = workgroupUniformLoad(&present_sides);

    for (var left = sides; left != 0u; left &= left - 1u) {
        let side = firstTrailingBit(left);
        sum_side(brick.first_triangle, origin, side, crossings_of(crossings, side), thread);
    }
    workgroupBarrier();
    if thread < 6u {
        planes[thread] = mean_plane(thread);
        if has_surface(thread) && atomicLoad(&sums[thread * SUMS]) < 256 { atomicOr(&unfilled, 1u << thread); }
    }
    workgroupBarrier();
    if thread == 0u { unfilled_sides = atomicLoad(&unfilled); }

    let inner = all(cell >= vec3<i32>(0)) && all(cell < vec3<i32>(8));
    var open_sides = workgroupUniformLoad(&unfilled_sides);
    if !inner { open_sides = 0u; }
    for (; open_sides != 0u; open_sides &= open_sides - 1u) { test_open(firstTrailingBit(open_sides), sides, thread); }
    workgroupBarrier();
    if inner && thread < 6u && has_surface(thread) {
        masks[thread] = coverage_mask(thread, voxel_seed(brick, cell) + thread);
        if (masks[thread] & 0xffffu) != 0xffffu { atomicStore(&part_filled, 1u); }
    }
    workgroupBarrier();
    if thread == 0u { voxel_states[batch * APRON_COUNT + (item & 1023u)] = voxel_state(); }
    if inner && thread < 6u && has_surface(thread) {
        let c = vec3<u32>(cell);
        let record = (batch * 512u + c.x + 8u * (c.y + 8u * c.z)) * RECORD_WORDS + thread * 3u;
        write_face(record, thread, voxel_seed(brick, cell) + thread);
    }
}

fn voxel_seed(brick: BatchBrick, cell: vec3<i32>) -> u32 {
    let c = vec3<u32>(cell);
    return pcg(brick.seed + c.x + 8u * (c.y + 8u * c.z));
}

fn published_count(thread: u32) -> u32 {
    if thread == 0u { list_size = atomicLoad(&list_count); }
    return workgroupUniformLoad(&list_size);
}

// Opposing parallel triangles in one plane are the contact of two solids, not a surface.
fn is_contact(normal: vec3<f32>, on: vec3<f32>, other: Triangle) -> bool {
    let n = triangle_normal(other);
    return dot(normal, n) < -0.9999 && abs(dot(normal, other.a - on) - 2.0 * TIE_SHIFT) < 5e-4
        && (other.material & TWO_SIDED) == 0u;
}

fn flag_contacts(first: u32, origin: vec3<f32>, count: u32, thread: u32) {
    for (var i = thread; i < count; i += 64u) {
        let t = load_triangle(first + list[i], origin);
        if (t.material & TWO_SIDED) != 0u { continue; }
        let n = triangle_normal(t);
        for (var j = 0u; j < count; j++) {
            if is_contact(n, t.a, load_triangle(first + (list[j] & 0xffffu), origin)) {
                list[i] |= CONTACT;
                contacts[atomicAdd(&contact_count, 1u)] = list[i] & 0xffffu;
                break;
            }
        }
    }
}

// Which of the thread's columns along an axis are inside a triangle's outline: where all three edges say so.
fn in_outline(t: Triangle, axis: u32, sign: f32, thread: u32) -> vec4<bool> {
    let u = axis_u(axis);
    let v = axis_v(axis);
    let a = vec2<f32>(t.a[u], t.a[v]);
    let b = vec2<f32>(t.b[u], t.b[v]);
    let c = vec2<f32>(t.c[u], t.c[v]);
    return on_left(a, b, sign, thread) & on_left(b, c, sign, thread) & on_left(c, a, sign, thread);
}

fn on_left(a: vec2<f32>, b: vec2<f32>, sign: f32, thread: u32) -> vec4<bool> {
    let e = b - a;
    let area = e.x * (columns_v(thread) - a.y) - e.y * (columns_u(thread) - a.x);
    return area * sign >= vec4<f32>(-1e-5 * (abs(e.x) + abs(e.y)));
}

// Where the thread's columns are.
fn columns_u(thread: u32) -> vec4<f32> {
    return (vec4<f32>(0.0, 1.0, 2.0, 3.0) + f32((thread & 3u) * 4u) + 0.5) / 16.0;
}

fn columns_v(thread: u32) -> f32 {
    return (f32(thread >> 2u) + 0.5) / 16.0;
}

fn to_bits(columns: vec4<bool>) -> u32 {
    let bits = select(vec4<u32>(0u), vec4<u32>(1u, 2u, 4u, 8u), columns);
    return bits.x | bits.y | bits.z | bits.w;
}

fn from_bits(bits: u32) -> vec4<bool> {
    return (vec4<u32>(bits) & vec4<u32>(1u, 2u, 4u, 8u)) != vec4<u32>(0u);
}

// Place of a column or coverage cell in an order in which the first n of 4^bits are spread evenly (Bayer, An Optimum
// Method for Two-Level Rendition of Continuous-Tone Pictures, 1973).
fn dither_order(x: u32, y: u32, bits: u32) -> u32 {
    var order = 0u;
    for (var bit = 0u; bit < bits; bit++) {
        order = (order << 2u) | ((((x ^ y) >> bit) & 1u) << 1u) | ((y >> bit) & 1u);
    }
    return order;
}

// Whether a triangle that lets light through stops this column's: so many columns do as the material is opaque.
fn stops(t: Triangle, entry: u32, p: vec3<f32>, thread: u32, k: u32) -> bool {
    let material = materials[t.material & MATERIAL_MASK];
    var opacity = material.opacity;
    if material.texture_alpha == 1u { opacity *= texture_texel(material, entry, t, p).w; }
    return opacity * 256.0 > f32(dither_order((thread & 3u) * 4u + k, thread >> 2u, 4u)) + 0.5;
}

// A place in one of the thread's columns.
fn on_column(axis: u32, k: u32, height: f32, thread: u32) -> vec3<f32> {
    var p = vec3<f32>(0.0);
    p[axis_u(axis)] = columns_u(thread)[k];
    p[axis_v(axis)] = columns_v(thread);
    p[axis] = height;
    return p;
}

// Where a plane is along an axis, in the thread's columns.
fn heights(n: vec3<f32>, offset: f32, axis: u32, thread: u32) -> vec4<f32> {
    return (offset - n[axis_u(axis)] * columns_u(thread) - n[axis_v(axis)] * columns_v(thread)) / n[axis];
}

// Which columns along an axis a triangle crosses in the voxel.
fn crossed(t: Triangle, n: vec3<f32>, axis: u32, at: vec4<f32>, thread: u32) -> u32 {
    if !(abs(n[axis]) > 1e-4) { return 0u; }
    let inside = in_outline(t, axis, select(-1.0, 1.0, n[axis] > 0.0), thread);
    return to_bits(inside & (at >= vec4<f32>(0.0)) & (at < vec4<f32>(1.0)));
}

// Enters a triangle's crossings with the thread's columns.
fn cut(first: u32, origin: vec3<f32>, entry: u32, thread: u32, crossings: ptr<function, Crossings>) {
    let index = entry & 0xffffu;
    let t = load_triangle(first + index, origin);
    let n = triangle_normal(t);
    let offset = dot(n, t.a);
    let x = heights(n, offset, 0u, thread);
    let y = heights(n, offset, 1u, thread);
    let z = heights(n, offset, 2u, thread);
    // Four columns an axis.
    var bits = crossed(t, n, 0u, x, thread) | (crossed(t, n, 1u, y, thread) << 4u) | (crossed(t, n, 2u, z, thread) << 8u);
    let count = select(0u, atomicLoad(&contact_count), (entry & CONTACT) != 0u);
    for (var j = 0u; j < count; j++) {
        let other = load_triangle(first + contacts[j], origin);
        if is_contact(n, t.a, other) {
            let side = select(vec3<f32>(-1.0), vec3<f32>(1.0), n < vec3<f32>(0.0));
            bits &= ~(to_bits(in_outline(other, 0u, side.x, thread)) | (to_bits(in_outline(other, 1u, side.y, thread)) << 4u)
                | (to_bits(in_outline(other, 2u, side.z, thread)) << 8u));
        }
    }
    var left = select(0u, bits, (t.material & TRANSLUCENT) != 0u);
    if left != 0u { atomicStore(&translucent, 1u); }
    for (; left != 0u; left &= left - 1u) {
        let column = firstTrailingBit(left);
        let axis = column >> 2u;
        let k = column & 3u;
        let height = select(select(x, y, axis == 1u), z, axis == 2u)[k];
        if !stops(t, first + index, on_column(axis, k, height, thread), thread, k) { bits &= ~(1u << column); }
    }
    let two_sided = (t.material & TWO_SIDED) != 0u;
    let low = (n < vec3<f32>(0.0)) | vec3<bool>(two_sided);
    let high = (n > vec3<f32>(0.0)) | vec3<bool>(two_sided);
    let levels = array<vec4<u32>, 3>(level(x), level(y), level(z));
    (*crossings).low_x = farther((*crossings).low_x, select(0u, bits, low.x), 65536u - levels[0], index);
    (*crossings).high_x = farther((*crossings).high_x, select(0u, bits, high.x), levels[0], index);
    (*crossings).low_y = farther((*crossings).low_y, select(0u, bits >> 4u, low.y), 65536u - levels[1], index);
    (*crossings).high_y = farther((*crossings).high_y, select(0u, bits >> 4u, high.y), levels[1], index);
    (*crossings).low_z = farther((*crossings).low_z, select(0u, bits >> 8u, low.z), 65536u - levels[2], index);
    (*crossings).high_z = farther((*crossings).high_z, select(0u, bits >> 8u, high.z), levels[2], index);
}

// 1 to 65535 for heights from 0 to 1.
fn level(height: vec4<f32>) -> vec4<u32> {
    return 1u + vec4<u32>(clamp(height, vec4<f32>(0.0), vec4<f32>(1.0)) * 65534.0);
}

fn farther(was: vec4<u32>, columns: u32, level: vec4<u32>, index: u32) -> vec4<u32> {
    return select(was, max(was, (level << vec4<u32>(16u)) | vec4<u32>(index)), from_bits(columns));
}

fn crossings_of(c: Crossings, side: u32) -> vec4<u32> {
    let x = select(c.low_x, c.high_x, side == 1u);
    let y = select(c.low_y, c.high_y, side == 3u);
    let z = select(c.low_z, c.high_z, side == 5u);
    return select(select(x, y, (side >> 1u) == 1u), z, (side >> 1u) == 2u);
}

fn crossed_sides(c: Crossings) -> u32 {
    var sides = 0u;
    for (var side = 0u; side < 6u; side++) {
        if any(crossings_of(c, side) != vec4<u32>(0u)) { sides |= 1u << side; }
    }
    return sides;
}

// Adds the thread's columns to a side's sums.
fn sum_side(first: u32, origin: vec3<f32>, side: u32, keys: vec4<u32>, thread: u32) {
    let axis = side >> 1u;
    var n_sum = vec3<f32>(0.0);
    var p_sum = vec3<f32>(0.0);
    var albedo = vec3<f32>(0.0);
    var emission = vec3<f32>(0.0);
    let bits = to_bits(keys != vec4<u32>(0u));
    // Columns of the same triangle at once.
    var left = bits;
    while left != 0u {
        let entry = keys[firstTrailingBit(left)] & 0xffffu;
        let own = left & to_bits((keys & vec4<u32>(0xffffu)) == vec4<u32>(entry));
        left &= ~own;
        let index = first + entry;
        let t = load_triangle(index, origin);
        let front = triangle_normal(t);
        let outward = (front[axis] > 0.0) == ((side & 1u) == 1u);
        let at = heights(front, dot(front, t.a), axis, thread);
        let share = select(vec4<f32>(0.0), vec4<f32>(1.0), from_bits(own));
        let count = f32(countOneBits(own));
        n_sum += select(-front, front, outward) * count;
        p_sum[axis_u(axis)] += dot(columns_u(thread), share);
        p_sum[axis_v(axis)] += columns_v(thread) * count;
        p_sum[axis] += dot(select(vec4<f32>(0.0), at, from_bits(own)), vec4<f32>(1.0));
        let material = materials[t.material & MATERIAL_MASK];
        if outward { emission += material.emission * count; }
        let textured = select(own, 0u, material.texture == NO_TEXTURE);
        if textured == 0u { albedo += min(material.base_color, vec3<f32>(0.95)) * count; }
        for (var texels = textured; texels != 0u; texels &= texels - 1u) {
            let k = firstTrailingBit(texels);
            // Stored as square roots of linear values.
            let root = texture_texel(material, index, t, on_column(axis, k, at[k], thread)).xyz;
            albedo += min(material.base_color * root * root, vec3<f32>(0.95));
        }
    }
    if bits == 0u { return; }
    let base = side * SUMS;
    atomicAdd(&sums[base], i32(countOneBits(bits)));
    add3(base + 1u, n_sum);
    add3(base + 4u, p_sum);
    add3(base + 7u, albedo);
    add3(base + 10u, emission / push.emission_max);
    atomicOr(&coverage[side * 8u + (thread >> 3u)], bits << ((thread & 7u) * 4u));
    let row = thread >> 2u;
    atomicAdd(&cells[side * 16u + (row >> 2u) * 4u + (thread & 3u)], countOneBits(bits));
}

fn add3(at: u32, value: vec3<f32>) {
    let fixed = vec3<i32>(round(value * FIXED));
    atomicAdd(&sums[at], fixed.x);
    atomicAdd(&sums[at + 1u], fixed.y);
    atomicAdd(&sums[at + 2u], fixed.z);
}

fn sum3(at: u32) -> vec3<f32> {
    return vec3<f32>(vec3<i32>(atomicLoad(&sums[at]), atomicLoad(&sums[at + 1u]), atomicLoad(&sums[at + 2u]))) / FIXED;
}

fn texture_texel(material: Material, entry: u32, t: Triangle, p: vec3<f32>) -> vec4<f32> {
    if material.texture == NO_TEXTURE { return vec4<f32>(1.0); }
    let e1 = t.b - t.a;
    let e2 = t.c - t.a;
    let n = cross(e1, e2);
    let area2 = dot(n, n);
    let wb = dot(cross(p - t.a, e2), n) / area2;
    let wc = dot(cross(e1, p - t.a), n) / area2;
    let first = triangle_lists[entry] * 4u;
    let uv12 = triangles[first + 3u];
    let uv0 = vec2<f32>(triangles[first + 1u].w, triangles[first + 2u].w);
    let uv = uv0 * (1.0 - wb - wc) + uv12.xy * wb + uv12.zw * wc;
    let size = vec2<u32>(material.texture_size & 0xffffu, material.texture_size >> 16u);
    let texel = min(vec2<u32>(fract(uv) * vec2<f32>(size)), size - 1u);
    return unpack4x8unorm(texels[material.texture + texel.y * size.x + texel.x]);
}

// Normal and offset of a side's mean plane as it will be stored; w < -1e6: no surface.
fn mean_plane(side: u32) -> vec4<f32> {
    let base = side * SUMS;
    let count = f32(atomicLoad(&sums[base]));
    if count == 0.0 { return vec4<f32>(0.0, 0.0, 0.0, -1e9); }
    let plane = plane_decode(side, encoded_plane(side));
    return vec4<f32>(plane.normal, plane.offset);
}

fn encoded_plane(side: u32) -> u32 {
    let base = side * SUMS;
    let n = sum3(base + 1u);
    let length2 = dot(n, n);
    let normal = select(side_normal(side), n * inverseSqrt(max(length2, 1e-12)), length2 > 1e-6);
    return plane_encode(side, normal, sum3(base + 4u) / f32(atomicLoad(&sums[base])));
}

fn has_surface(side: u32) -> bool {
    return planes[side].w > -1e6;
}

fn is_covered(side: u32, p: vec3<f32>) -> bool {
    let axis = side >> 1u;
    let x = u32(clamp(p[axis_u(axis)] * 16.0, 0.0, 15.0));
    let y = u32(clamp(p[axis_v(axis)] * 16.0, 0.0, 15.0));
    return ((atomicLoad(&coverage[side * 8u + (y >> 1u)]) >> ((y & 1u) * 16u + x)) & 1u) != 0u;
}

// Counts the uncovered columns whose point on the plane lies in the voxel and is not hidden by another side.
fn test_open(side: u32, sides: u32, thread: u32) {
    let axis = side >> 1u;
    let plane = planes[side];
    let at = heights(plane.xyz, plane.w, axis, thread);
    let covered = atomicLoad(&coverage[side * 8u + (thread >> 3u)]) >> ((thread & 7u) * 4u);
    var open = to_bits((at > vec4<f32>(-0.02)) & (at < vec4<f32>(1.02))) & ~covered;
    for (var others = sides & ~(1u << side); others != 0u; others &= others - 1u) {
        let b = firstTrailingBit(others);
        let before = planes[b];
        let opposite = planes[b ^ 1u];
        for (var left = open; left != 0u; left &= left - 1u) {
            let k = firstTrailingBit(left);
            let p = on_column(axis, k, at[k], thread) + plane.xyz * 0.02;
            if dot(before.xyz, p) - before.w >= 0.016 || !is_covered(b, p) { continue; }
            if opposite.w > -1e6 && dot(opposite.xyz, p) > opposite.w && is_covered(b ^ 1u, p) { continue; }
            open &= ~(1u << k);
        }
    }
    let row = thread >> 2u;
    atomicAdd(&cells[side * 16u + (row >> 2u) * 4u + (thread & 3u)], countOneBits(open & 15u) << 16u);
}

// 4 x 4 coverage: cells at least half covered of what is not hidden; wholly hidden ones only beside a covered one; if
// none would be set, the fullest. Where light comes through, and on the edges of what is thin, which cells are too coarse
// for: as many cells as are covered on average over voxels. The mask | columns of the cross-section that it stands for << 16.
fn coverage_mask(side: u32, seed: u32) -> u32 {
    let is_dithered = atomicLoad(&translucent) != 0u || is_edge(side);
    let random = pcg(seed + 3u);
    var mask = 0u;
    var fullest = 0u;
    var fullest_count = 0u;
    var fullest_area = 0u;
    var total = 0u;
    var area = 0u;
    for (var k = 0u; k < 16u; k++) {
        let covered = atomicLoad(&cells[side * 16u + k]) & 0xffffu;
        let open = atomicLoad(&cells[side * 16u + k]) >> 16u;
        total += covered;
        if covered > fullest_count {
            fullest = k;
            fullest_count = covered;
            fullest_area = covered + open;
        }
        var is_set = select(covered >= open, beside_covered(side, k), covered + open == 0u);
        if is_dithered && covered + open > 0u {
            let order = dither_order((k & 3u) ^ (random & 3u), (k >> 2u) ^ ((random >> 2u) & 3u), 2u);
            let threshold = (f32(order) + unit_float(random)) / 16.0;
            is_set = f32(covered) > threshold * f32(covered + open);
        }
        if is_set {
            mask |= 1u << k;
            area += covered + open;
        }
    }
    if total >= 252u {
        mask = 0xffffu;
        area = total;
    } else if mask == 0u && !is_dithered {
        mask = 1u << fullest;
        area = fullest_area;
    }
    return mask | (area << 16u);
}

// Mean places of an axis's sides, low and high; the same if a side is missing, or all but.
fn thickness(axis: u32) -> vec2<f32> {
    let low_count = f32(atomicLoad(&sums[axis * 2u * SUMS]));
    let high_count = f32(atomicLoad(&sums[(axis * 2u + 1u) * SUMS]));
    if min(low_count, high_count) < 5.0 { return vec2<f32>(0.0); }
    return vec2<f32>(sum3(axis * 2u * SUMS + 4u)[axis] / low_count, sum3((axis * 2u + 1u) * SUMS + 4u)[axis] / high_count);
}

// Whether a side is the edge of a board or rod that is thinner than EDGE_MAX, and does not emit.
fn is_edge(side: u32) -> bool {
    if emits(side) { return false; }
    for (var axis = 0u; axis < 3u; axis++) {
        let between = thickness(axis);
        if axis != (side >> 1u) && between.y > between.x && between.y - between.x < EDGE_MAX { return true; }
    }
    return false;
}

fn emits(side: u32) -> bool {
    let base = side * SUMS + 10u;
    return atomicLoad(&sums[base]) + atomicLoad(&sums[base + 1u]) + atomicLoad(&sums[base + 2u]) > 0;
}

fn beside_covered(side: u32, k: u32) -> bool {
    let x = i32(k & 3u);
    let y = i32(k >> 2u);
    for (var v = max(y - 1, 0); v <= min(y + 1, 3); v++) {
        for (var u = max(x - 1, 0); u <= min(x + 1, 3); u++) {
            if (atomicLoad(&cells[side * 16u + u32(v * 4 + u)]) & 0xffffu) != 0u { return true; }
        }
    }
    return false;
}

fn write_face(record: u32, side: u32, seed: u32) {
    let base = side * SUMS;
    let mask = masks[side] & 0xffffu;
    let share = f32(masks[side] >> 16u) / 256.0;
    let albedo = sum3(base + 7u) / f32(atomicLoad(&sums[base]));
    // Flux over what a ray can hit.
    let emission = sum3(base + 10u) * push.emission_max / 256.0 / max(share, 1e-3);
    voxel_records[record] = encoded_plane(side);
    if atomicLoad(&part_filled) != 0u {
        let dither = vec3<f32>(unit_float(pcg(seed)), unit_float(pcg(seed + 1u)), unit_float(pcg(seed + 2u)));
        voxel_records[record + 1u] = albedo_encode(albedo, dither) | (mask << 16u);
    } else {
        voxel_records[record + 1u] = fine_albedo_encode(albedo);
    }
    voxel_records[record + 2u] = rgb9e5_encode(emission, vec3<f32>(0.5));
}

// What neighbours may know: sides with surface 6 | axes with a thin wall 3 << 6 | sides that emit 6 << 9 | part-filled << 15
// | lets light through << 16.
fn voxel_state() -> u32 {
    var state = (atomicLoad(&part_filled) << 15u) | (atomicLoad(&translucent) << 16u);
    for (var side = 0u; side < 6u; side++) {
        if !has_surface(side) { continue; }
        state |= 1u << side;
        if emits(side) { state |= 1u << (9u + side); }
    }
    for (var axis = 0u; axis < 3u; axis++) {
        let between = thickness(axis);
        if between.y > between.x && between.y < 0.995 && between.x > 0.005 { state |= 1u << (6u + axis); }
    }
    return state;
}
