// What a CUDA program takes from its compiler, for a compiler of C++: one thread after the other.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#define __device__
#define __global__
#define __forceinline__ inline
#define __launch_bounds__(threads)

struct uint2 {
    unsigned x, y;
};

struct float4 {
    float x, y, z, w;
};

static struct {
    unsigned x;
} blockIdx, threadIdx;

inline uint2 make_uint2(unsigned x, unsigned y) {
    return {x, y};
}

inline float4 make_float4(float x, float y, float z, float w) {
    return {x, y, z, w};
}

template <class T> T __ldg(const T *place) {
    return *place;
}

// The bytes of a buffer, as whatever a parameter points to.
struct Buffer {
    std::vector<unsigned char> bytes;

    template <class T> operator T *() {
        return reinterpret_cast<T *>(bytes.data());
    }
};

inline Buffer load(const std::string &path) {
    Buffer buffer;
    FILE *file = std::fopen(path.c_str(), "rb");
    if (!file) {
        std::perror(path.c_str());
        std::exit(1);
    }
    unsigned char chunk[1 << 16];
    for (size_t n; (n = std::fread(chunk, 1, sizeof chunk, file)) > 0;) {
        buffer.bytes.insert(buffer.bytes.end(), chunk, chunk + n);
    }
    std::fclose(file);
    return buffer;
}

inline Buffer poisoned(size_t bytes) {
    return {std::vector<unsigned char>(bytes, 0xCD)};
}

inline void save(const std::string &path, const Buffer &buffer) {
    FILE *file = std::fopen(path.c_str(), "wb");
    if (!file || std::fwrite(buffer.bytes.data(), 1, buffer.bytes.size(), file) != buffer.bytes.size()) {
        std::perror(path.c_str());
        std::exit(1);
    }
    std::fclose(file);
}
