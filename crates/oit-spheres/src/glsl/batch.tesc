// As many isolines of as many points as a batch has atoms, or a few more.
layout(vertices = 1) out;

layout(std430, set = 0, binding = 8) readonly buffer Batches { uvec4 data[]; } batches;
layout(location = 0) in uint batch_number[];
layout(location = 0) patch out uvec3 batch_of_patch;

void main() {
    uvec3 part = batches.data[batch_number[0]].xyz;
    batch_of_patch = part;
    // Points of a line; one fewer are its segments, of which there is at least 1 and at most 64.
    uint points = clamp(uint(ceil(sqrt(float(part.y)))), 2u, 65u);
    gl_TessLevelOuter[0] = float((part.y + points - 1u) / points);
    gl_TessLevelOuter[1] = float(points - 1u);
}
