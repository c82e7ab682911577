/* What compiled kernels expect from numba's runtime, and what the loader asks.
 *
 * Kernels allocate arrays through NRT_MemInfo_alloc_aligned, lists through
 * NRT_MemInfo_new_varsize_dtor, and give up what they do not return through NRT_MemInfo_call_dtor.
 * They touch `count` and `data` in code of their own, so members lie as numba has them. */

#if defined(__x86_64__)
#include <cpuid.h>
#endif
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#if defined(_WIN32)
#define PUBLIC __declspec(dllexport)
#else
#define PUBLIC __attribute__((visibility("default")))
#endif

typedef void destroy(void *data);

typedef struct {
    size_t count;
    destroy *destructor;
    void *destructor_info;
    void *data;
    size_t size;
    void *external;
    int apart; /* ours: whether `data` is a block of its own */
} block;

void *NRT_MemInfo_varsize_realloc(block *b, size_t size);

void *NRT_MemInfo_alloc_aligned(size_t size, unsigned align)
{
    size_t room = sizeof(block) + align;
    if (align == 0 || size > SIZE_MAX - room)
        return NULL;
    block *b = malloc(room + size);
    if (b == NULL)
        return NULL;
    uintptr_t first = (uintptr_t)(b + 1);
    *b = (block){.count = 1, .size = size};
    b->data = (void *)(first + (align - first % align) % align);
    return b;
}

/* A list inside a kernel: its elements lie apart, since they move when it grows. */
void *NRT_MemInfo_new_varsize_dtor(size_t size, destroy *destructor)
{
    block *b = calloc(1, sizeof(block));
    if (b == NULL)
        return NULL;
    b->count = 1;
    b->destructor = destructor;
    b->apart = 1;
    if (NRT_MemInfo_varsize_realloc(b, size) == NULL) {
        free(b);
        return NULL;
    }
    return b;
}

void *NRT_MemInfo_varsize_realloc(block *b, size_t size)
{
    void *data = realloc(b->data, size > 0 ? size : 1);
    if (data != NULL) {
        b->data = data;
        b->size = size;
    }
    return data;
}

void NRT_MemInfo_call_dtor(block *b)
{
    if (b->destructor != NULL)
        b->destructor(b->data);
    if (b->apart)
        free(b->data);
    free(b);
}

/* Room for a moment, such as a copy before an assignment between overlapping slices. */
void *NRT_Allocate(size_t size) { return malloc(size > 0 ? size : 1); }

void NRT_Free(void *room) { free(room); }

/* A result is owned by a capsule of Python, whose pointer Python's own function finds: the loader
 * hands it over, since this library is linked with no Python. */
static block *(*inside)(void *capsule, const char *name);

PUBLIC void geosurf_use(void *function) { inside = function; }

/* One owner less; called by Python when a result is garbage. */
PUBLIC void geosurf_release(void *capsule)
{
    block *b = inside(capsule, NULL);
    if (__atomic_sub_fetch(&b->count, 1, __ATOMIC_ACQ_REL) == 0)
        NRT_MemInfo_call_dtor(b);
}

double numba_frexp(double x, int *exponent)
{
    *exponent = 0;
    return isfinite(x) ? frexp(x, exponent) : x;
}

double numba_ldexp(double x, int exponent) { return isfinite(x) ? ldexp(x, exponent) : x; }

/* 3 if this machine runs code for x86-64-v3 (levels of the x86-64 psABI), else 1; other processors
 * have one level. Asked from the processor itself: what compilers bring for it differs. */
PUBLIC int geosurf_level(void)
{
#if defined(__x86_64__)
    unsigned a, b, c, d, saved, above;
    const unsigned wanted = bit_FMA | bit_MOVBE | bit_OSXSAVE | bit_AVX | bit_F16C;
    if (!__get_cpuid(1, &a, &b, &c, &d) || (c & wanted) != wanted)
        return 1;
    __asm__("xgetbv" : "=a"(saved), "=d"(above) : "c"(0)); /* what the system saves */
    if ((saved & 6) != 6)
        return 1;
    const unsigned more = 1u << 3 | 1u << 5 | 1u << 8; /* BMI, AVX2, BMI2 */
    if (!__get_cpuid_count(7, 0, &a, &b, &c, &d) || (b & more) != more)
        return 1;
    if (!__get_cpuid(0x80000001, &a, &b, &c, &d) || !(c & 1u << 5)) /* LZCNT */
        return 1;
    return 3;
#else
    return 1;
#endif
}
