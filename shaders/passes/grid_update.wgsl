// Writes the host's changes into the grid: pairs of address and value, no address twice.

struct GridUpdatePush {
    count: u32,
}
var<immediate> push: GridUpdatePush;

@res var<storage, read> grid_writes: array<vec2<u32>>;
@res var<storage, read_write> world_grid: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= push.count { return; }
    let write = grid_writes[id.x];
    world_grid[write.x] = write.y;
}
