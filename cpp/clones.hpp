// A loop that is compiled twice where that is possible, for AVX2, too; the answers are the same bytes.
#pragma once

/// What a function calls becomes part of it, also of a clone.
#if defined(__GNUC__)
#define VBBENCH_FLAT __attribute__((flatten))
#else
#define VBBENCH_FLAT
#endif

#if defined(__x86_64__) && defined(__ELF__) && defined(__GLIBC__) && !defined(VBBENCH_SANITIZED)
#define VBBENCH_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define VBBENCH_WIDE
#endif
