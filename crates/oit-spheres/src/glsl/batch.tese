// A point of a patch is an atom of its batch, or one too many.
layout(isolines, equal_spacing, point_mode) in;

layout(location = 0) patch in uvec3 batch_of_patch;
layout(location = 0) out uvec2 sphere;

void main() {
    uint x = uint(round(gl_TessCoord.x * gl_TessLevelOuter[1]));
    uint y = uint(round(gl_TessCoord.y * gl_TessLevelOuter[0]));
    uint number = y * uint(gl_TessLevelOuter[1] + 1.5) + x;
    bool beyond = number >= batch_of_patch.y;
    sphere = beyond ? uvec2(0xffffffffu) : uvec2(batch_of_patch.z, batch_of_patch.x + number);
}
