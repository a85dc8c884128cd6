// A loop that is compiled twice where that is possible, for AVX2, too; the answers are the same bytes.
#pragma once

#if defined(__x86_64__) && defined(__ELF__) && defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
#define VBBENCH_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define VBBENCH_WIDE
#endif
