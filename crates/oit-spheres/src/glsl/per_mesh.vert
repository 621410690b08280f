// One draw a mesh: instances are looked up.
layout(std430, set = 0, binding = 12) readonly buffer ByMesh { uint data[]; } by_mesh;
layout(location = 0) out uvec2 sphere;

void main() {
    sphere = uvec2(by_mesh.data[gl_InstanceIndex], gl_VertexIndex);
}
