// One patch a batch.
layout(location = 0) out uint batch_number;

void main() {
    batch_number = uint(gl_VertexIndex);
}
