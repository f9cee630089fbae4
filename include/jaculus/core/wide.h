#pragma once
// JACULUS_WIDE before a function: compiled twice, for AVX2 and for any x86-64, the better one taken
// when the program is loaded. AVX2 has no fused multiply-add: each product and sum is rounded as
// everywhere, and loops over elements give the same bits, four at a time or one. Functions that it
// calls must be JACULUS_INLINE. Compilers and sanitizers that lack this have the one version.

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__)
#define JACULUS_WIDE __attribute__((target_clones("avx2", "default")))
#define JACULUS_INLINE __attribute__((always_inline)) inline
#else
#define JACULUS_WIDE
#define JACULUS_INLINE inline
#endif
