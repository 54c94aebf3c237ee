// Direct irradiance of the listed faces where there are more lights than a face may ask: its cost does not grow with them.
// One workgroup a brick. Each thread chooses one of its share of the lights, by what they can bring to the brick; of those
// 64 each sample of a face chooses `direct_lights`, by what they bring to it unshadowed. (Resampled importance sampling:
// Talbot, Cline and Egbert, Importance Resampling for Global Illumination, EGSR 2005; by weighted reservoirs: Bitterli et
// al., Spatiotemporal Reservoir Resampling, SIGGRAPH 2020.)

#import lib/faces.wgsl
#import lib/lights.wgsl
#import lib/shadows.wgsl
#import lib/sweep.wgsl

@res var<storage, read> lights: array<Light>;
@res var<storage, read_write> face_irradiance: array<vec2<u32>>;

struct Choice {
    light: u32,
    // Reciprocal of the probability that it was chosen.
    weight: f32,
    // What all of those can bring to the brick that it was chosen from; 0: there is nothing to choose from.
    bound: f32,
}

// By thread.
var<workgroup> found: array<Choice, 64>;
// The same, the strongest first.
var<workgroup> choices: array<Choice, 64>;

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let brick = light_bricks[group.x];
    let own = choose(brick, thread);
    found[thread] = own;
    workgroupBarrier();
    var rank = 0u;
    var count = 0u;
    for (var other = 0u; other < 64u; other++) {
        let bound = found[other].bound;
        rank += u32(bound > own.bound || (bound == own.bound && other < thread));
        count += u32(bound > 0.0);
    }
    choices[rank] = own;
    workgroupBarrier();
    var end = push.face_count;
    if group.x + 1u < push.brick_count { end = light_bricks[group.x + 1u].first_face; }
    for (var index = brick.first_face + thread; index < end; index += 64u) { face_irradiance[index] = direct(index, count); }
}

// One of every 64th light.
fn choose(brick: LightBrick, thread: u32) -> Choice {
    let position = (vec3<u32>(brick.position) >> vec3<u32>(0u, 10u, 20u)) & vec3<u32>(1023u);
    let origin = position * BRICK_VOXELS;
    let middle = vec3<f32>(origin) + 0.5 * f32(BRICK_VOXELS);
    var u = choice_place(hash3(origin + frame.seed_origin) ^ thread, push.update);
    var choice = Choice();
    var chosen = 0.0;
    for (var k = thread; k < frame.light_count; k += 64u) {
        let bound = light_bound(lights[k], middle);
        if bound <= 0.0 { continue; }
        choice.bound += bound;
        let share = bound / choice.bound;
        if u < share {
            choice.light = k;
            chosen = bound;
        }
        u = remainder(u, share);
    }
    choice.weight = choice.bound / max(chosen, 1e-30);
    return choice;
}

// What the chosen lights bring to a face.
fn direct(index: u32, count: u32) -> vec2<u32> {
    let face = load_face(vis_faces[index]);
    let normal = face_normal(face);
    var e = vec3<f32>(0.0);
    var samples = 0u;
    let sample_count = at_run_time(frame.direct_samples, index);
    let parts = at_run_time(frame.direct_lights, index);
    for (var s = 0u; s < sample_count; s++) {
        let time = push.update * sample_count + s;
        let p = face_point(face, r2(face.seed ^ 0x68bc21ebu, time), pcg(face.seed + time));
        if p.w == 0.0 { continue; }
        samples++;
        for (var part = 0u; part < parts; part++) { e += reservoir(face, normal, p.xyz, time, part, count); }
    }
    if samples == 0u { return vec2<u32>(INVALID); }
    return pack_irradiance(e / f32(samples));
}

// What one of a part of the choices brings to p, for all of them. Parts are dealt to and fro, so that the strong lie apart.
fn reservoir(face: Face, normal: vec3<f32>, p: vec3<f32>, time: u32, part: u32, count: u32) -> vec3<f32> {
    var u = choice_place(face.seed ^ (part * 0x9e3779b9u), time);
    var sum = 0.0;
    var chosen: LightSample;
    var chosen_light = 0u;
    for (var row = 0u; row * frame.direct_lights < count; row++) {
        let place = row * frame.direct_lights + select(part, frame.direct_lights - 1u - part, (row & 1u) == 1u);
        if place >= count { continue; }
        let choice = choices[place];
        let light = lights[choice.light];
        let sample = sample_light(light, p, face.seed + choice.light, time);
        let weight = sample.strength * dot(normal, sample.direction) * choice.weight * brightness(light.color);
        if weight <= 0.0 { continue; }
        sum += weight;
        let share = weight / sum;
        if u < share {
            chosen = sample;
            chosen_light = choice.light;
        }
        u = remainder(u, share);
    }
    if sum == 0.0 || !light_arrives(lights[chosen_light], chosen, p, normal) { return vec3<f32>(0.0); }
    let color = lights[chosen_light].color;
    return color * (sum / brightness(color));
}

// Steps of the golden ratio, in 32-bit fixed point.
fn choice_place(seed: u32, index: u32) -> f32 {
    return unit_float(pcg(seed ^ 0x27d4eb2fu) + 0x9e3779b9u * index);
}

// What is left of a number from 0 to 1 that has chosen with this probability: again evenly from 0 to 1.
fn remainder(u: f32, share: f32) -> f32 {
    if u < share { return u / share; }
    return min((u - share) / (1.0 - share), 0.99999994);
}
