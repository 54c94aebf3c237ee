// Where a probe of the last frame is now.

#import lib/probes.wgsl

struct Followed {
    in_view: bool,
    // Whether its surface is there, too.
    is_there: bool,
    surface: Surface,
    pixel: vec2<u32>,
}

// How far (pixels) motion may point past where a probe was.
const SAME_PLACE: f32 = 1.5;

// `position`: where it is if it has stood still. The motion image says where pixels come from, not where they go to: if what
// is at that place comes from elsewhere, the probe's own surface, if it has moved alike, lies as far off to the other side,
// and what is there must come from the probe's place.
fn follow_probe(position: vec3<f32>, normal: vec3<f32>) -> Followed {
    var followed = Followed();
    let clip = view.clip * vec4<f32>(position, 1.0);
    let size = vec2<f32>(view.size);
    let place = (clip.xy / max(clip.w, 1e-6) * 0.5 + 0.5) * size;
    followed.in_view = clip.w > 0.0 && all(place >= vec2<f32>(0.0)) && all(place < size);
    if !followed.in_view { return followed; }
    followed.pixel = vec2<u32>(place);
    followed.surface = load_surface(followed.pixel);
    let past_clip = view.previous_clip * vec4<f32>(position, 1.0);
    let was = (past_clip.xy / max(past_clip.w, 1e-6) * 0.5 + 0.5) * size;
    let has_motion = at_run_time(view.has_motion, followed.pixel.x) == 1u;
    let off = place + motion_of(followed.pixel) * size - was;
    if !has_motion || !(length(off) > 0.5) {
        followed.is_there = followed.surface.valid && dot(normal, followed.surface.normal) >= SAME_FACING
            && abs(dot(followed.surface.position - position, followed.surface.normal))
                <= SAME_PLANE * length(position) + 1e-3;
        followed.surface = Surface(true, position, normal);
        return followed;
    }
    let moved = place - off;
    followed.in_view = all(moved >= vec2<f32>(0.0)) && all(moved < size);
    if !followed.in_view { return followed; }
    followed.pixel = vec2<u32>(moved);
    followed.surface = load_surface(followed.pixel);
    if !followed.surface.valid { return followed; }
    let before = surface_before(followed.surface, followed.pixel);
    let seen = surface_word(Surface(true, position - view.camera_delta, normal));
    followed.is_there = length(moved + motion_of(followed.pixel) * size - was) < SAME_PLACE
        && is_same_surface(seen, followed.surface.normal, before.distance, before.slack);
    return followed;
}
