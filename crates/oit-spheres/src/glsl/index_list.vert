// One draw over a list of atoms.
layout(std430, set = 0, binding = 11) readonly buffer List { uvec2 data[]; } list;
layout(location = 0) out uvec2 sphere;

void main() {
    sphere = list.data[gl_VertexIndex].yx;
}
