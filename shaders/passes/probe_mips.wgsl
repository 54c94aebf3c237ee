// Which probes stand for the tiles around, for pixels whose own tiles have none: one thread a cell (`mip_start`).

#import lib/probes.wgsl

@res var<storage, read_write> probes: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    var level = 1u;
    var rest = id.x;
    while level <= PROBE_MIPS {
        let cells = mip_cells(level).x * mip_cells(level).y;
        if rest < cells { break; }
        rest -= cells;
        level++;
    }
    if level > PROBE_MIPS { return; }
    let width = mip_cells(level).x;
    let cell = vec2<u32>(rest % width, rest / width);
    var named = vec4<f32>(0.0);
    for (var quarter = 0u; quarter < 4u; quarter++) {
        let side = 1u << (level - 1u);
        let corner = (2u * cell + vec2<u32>(quarter & 1u, quarter >> 1u)) * side;
        named[quarter] = f32(first_probe(corner, side));
    }
    probes[mip_start(level) + rest] = named;
}

// One of the probes of `side` x `side` tiles, counted from one; 0: they have none.
fn first_probe(corner: vec2<u32>, side: u32) -> u32 {
    for (var k = 0u; k < PROBE_LAYERS * side * side; k++) {
        let tile = corner + vec2<u32>(k % side, k / side % side);
        if any(tile >= view.tiles) { continue; }
        let index = probe_index(tile, k / (side * side));
        if u32(probes[index * 2u].w) != PROBE_NONE { return index + 1u; }
    }
    return 0u;
}
