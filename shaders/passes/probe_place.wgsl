// One probe a tile, on a pixel that moves through the tile over time. A probe: position (camera-relative metres), normal.

#import lib/probes.wgsl
#import lib/random.wgsl

struct ViewPush {
    frame_index: u32,
}
var<immediate> push: ViewPush;

// Two words of four floats a probe: position, w = 1 where valid; normal, w = its pixel's bits (x | y << 16).
@res var<storage, read_write> probes: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= view.tiles.x * view.tiles.y { return; }
    let tile = vec2<u32>(id.x % view.tiles.x, id.x / view.tiles.x);
    var surface = Surface();
    var pixel = vec2<u32>(0u);
    // A tile may hold sky: a few places are tried. The rays have the sequence's other part.
    for (var attempt = 0u; attempt < 4u && !surface.valid; attempt++) {
        let place = kronecker4(attempt, push.frame_index).xy;
        pixel = tile * view.tile_size + vec2<u32>(place * f32(view.tile_size));
        if all(pixel < view.size) { surface = load_surface(pixel); }
    }
    probes[id.x * 2u] = vec4<f32>(surface.position, select(0.0, 1.0, surface.valid));
    probes[id.x * 2u + 1u] = vec4<f32>(surface.normal, bitcast<f32>(pixel.x | (pixel.y << 16u)));
}
