// The C sample's G-buffer: depth and the face's normal, turned towards the camera.

struct Camera {
    // Projection times rotation: from the world, relative to the eye, to clip space.
    clip_from_relative: mat4x4<f32>,
    eye: vec3<f32>,
}

struct Vertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) from_eye: vec3<f32>,
    @location(1) @interpolate(flat) normal: vec3<f32>,
}

var<immediate> camera: Camera;

@vertex
fn vertex_main(@location(0) position: vec3<f32>, @location(1) normal: vec3<f32>) -> Vertex {
    let from_eye = position - camera.eye;
    return Vertex(camera.clip_from_relative * vec4(from_eye, 1.0), from_eye, normal);
}

@fragment
fn fragment_main(vertex: Vertex) -> @location(0) vec4<f32> {
    return vec4(faceForward(vertex.normal, vertex.from_eye, vertex.normal), 0.0);
}
