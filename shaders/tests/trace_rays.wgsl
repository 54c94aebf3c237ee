// One ray a thread: what `trace` makes of it.

#import lib/hdda.wgsl

struct TestRay {
    origin: vec3<f32>,
    t_max: f32,
    direction: vec3<f32>,
    // As Start.error.
    start_error: f32,
    // Of the surface at the origin, or zero.
    normal: vec3<f32>,
}

struct TestHit {
    kind: u32,
    t: f32,
    light: u32,
    side: u32,
    cell: vec3<i32>,
}

@res var<storage, read> rays: array<TestRay>;
@res var<storage, read_write> ray_hits: array<TestHit>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&rays) { return; }
    let ray = rays[id.x];
    let hit = trace(Start(ray.origin, ray.normal, ray.start_error), ray.direction, ray.t_max);
    ray_hits[id.x] = TestHit(hit.kind, hit.t, hit.light, hit.side, hit.cell);
}
