// A loop that is compiled twice where that is possible, for AVX2, too; the answers are the same bytes.
#pragma once

#include <cstddef>  // for __GLIBC__

// GCC's clones alone: clang forgets inline functions that only clones call.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__ELF__) && defined(__GLIBC__) && \
    !defined(VBBENCH_SANITIZED)
#define VBBENCH_WIDE __attribute__((target_clones("avx2", "default")))
/// With all that it calls.
#define VBBENCH_WIDE_WHOLE VBBENCH_WIDE __attribute__((flatten))
#else
#define VBBENCH_WIDE
#define VBBENCH_WIDE_WHOLE
#endif
