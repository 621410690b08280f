// One draw an object: its number is the first instance.
layout(location = 0) out uvec2 sphere;

void main() {
    sphere = uvec2(gl_InstanceIndex, gl_VertexIndex);
}
