// CUDA's own segmented sort (CUB's DeviceSegmentedSort) of 64-bit keys, timed by events.
#include <cub/device/device_segmented_sort.cuh>
#include <cuda_runtime.h>

typedef unsigned long long Key;

#define TRY(call)                                                                                  \
    do {                                                                                           \
        cudaError_t error = (call);                                                                \
        if (error != cudaSuccess) {                                                                \
            return error;                                                                          \
        }                                                                                          \
    } while (0)

// `offsets` has one more entry than there are segments. `milliseconds` gets `runs` times; one run
// more goes before them. Frees nothing where it fails: the process ends then.
extern "C" int oit_segmented_sort(
    const Key *keys, Key *sorted, int items, const int *offsets, int segments, float *milliseconds,
    int runs
) {
    Key *from, *to;
    int *bounds;
    void *scratch = nullptr;
    size_t scratch_bytes = 0;
    TRY(cudaMalloc(&from, sizeof(Key) * (size_t(items) + 1)));
    TRY(cudaMalloc(&to, sizeof(Key) * (size_t(items) + 1)));
    TRY(cudaMalloc(&bounds, sizeof(int) * (size_t(segments) + 1)));
    TRY(cudaMemcpy(from, keys, sizeof(Key) * items, cudaMemcpyHostToDevice));
    TRY(cudaMemcpy(bounds, offsets, sizeof(int) * (size_t(segments) + 1), cudaMemcpyHostToDevice));
    TRY(cub::DeviceSegmentedSort::SortKeys(
        scratch, scratch_bytes, from, to, items, segments, bounds, bounds + 1
    ));
    TRY(cudaMalloc(&scratch, scratch_bytes + 1));
    cudaEvent_t before, after;
    TRY(cudaEventCreate(&before));
    TRY(cudaEventCreate(&after));
    for (int run = -1; run < runs; run += 1) {
        TRY(cudaMemset(to, 0xCD, sizeof(Key) * items));
        TRY(cudaEventRecord(before));
        TRY(cub::DeviceSegmentedSort::SortKeys(
            scratch, scratch_bytes, from, to, items, segments, bounds, bounds + 1
        ));
        TRY(cudaEventRecord(after));
        TRY(cudaEventSynchronize(after));
        if (run >= 0) {
            TRY(cudaEventElapsedTime(milliseconds + run, before, after));
        }
    }
    TRY(cudaMemcpy(sorted, to, sizeof(Key) * items, cudaMemcpyDeviceToHost));
    cudaEventDestroy(before);
    cudaEventDestroy(after);
    cudaFree(scratch);
    cudaFree(bounds);
    cudaFree(to);
    cudaFree(from);
    return 0;
}

extern "C" const char *oit_error(int error) {
    return cudaGetErrorString(cudaError_t(error));
}
