/* A real: one number (LANES 1), or a vector of one number of each of LANES runs (8: AVX-512, 4: AVX2).

   Numbers are doubles; on a CUDA device they may be floats (SINGLE), but for times and what depends on them. */
#include <math.h>

#ifdef SINGLE
typedef float number;
#else
typedef double number;
#endif
#ifdef __CUDACC__
#define INLINE static __host__ __device__ inline
#else
#define INLINE static inline
#endif

#if LANES == 1

typedef number real;
typedef int mask;
#define power pow
#define hyperbolic tanh
#define exponential exp
#define root sqrt
#define magnitude fabs
#define with_sign copysign
INLINE real same(number x) { return x; }
INLINE int any_finite(real x) { return isfinite(x); }
INLINE real larger(real a, real b) { return a > b ? a : b; }
INLINE real smaller(real a, real b) { return a < b ? a : b; }
INLINE real choose(mask condition, real a, real b) { return condition ? a : b; }
INLINE real sign(real x) { return x > 0 ? 1 : x < 0 ? -1 : 0; }

#else

#include <immintrin.h>
typedef double real __attribute__((vector_size(8 * LANES)));
typedef long long mask __attribute__((vector_size(8 * LANES)));
#define SIGN_BIT ((mask){} + (long long)(1ULL << 63))
INLINE real same(number x) { return (real){} + x; }

#if LANES == 8
real _ZGVeN8vv_pow(real, real); /* libmvec, the vector part of glibc's libm */
real _ZGVeN8v_tanh(real);
real _ZGVeN8v_exp(real);
#define power _ZGVeN8vv_pow
#define hyperbolic _ZGVeN8v_tanh
#define exponential _ZGVeN8v_exp
INLINE real root(real x) { return _mm512_sqrt_pd(x); }
INLINE real larger(real a, real b) { return _mm512_max_pd(a, b); }
INLINE real smaller(real a, real b) { return _mm512_min_pd(a, b); }
INLINE real choose(mask condition, real a, real b) {
    return _mm512_mask_mov_pd(b, _mm512_movepi64_mask((__m512i)condition), a);
}
INLINE int any_finite(real x) { return _mm512_movepi64_mask((__m512i)(x - x == 0.0)) != 0; }
#else
real _ZGVdN4vv_pow(real, real);
real _ZGVdN4v_tanh(real);
real _ZGVdN4v_exp(real);
#define power _ZGVdN4vv_pow
#define hyperbolic _ZGVdN4v_tanh
#define exponential _ZGVdN4v_exp
INLINE real root(real x) { return _mm256_sqrt_pd(x); }
INLINE real larger(real a, real b) { return _mm256_max_pd(a, b); }
INLINE real smaller(real a, real b) { return _mm256_min_pd(a, b); }
INLINE real choose(mask condition, real a, real b) { return _mm256_blendv_pd(b, a, (real)condition); }
INLINE int any_finite(real x) { return _mm256_movemask_pd((real)(x - x == 0.0)) != 0; }
#endif

INLINE real magnitude(real x) { return (real)((mask)x & ~SIGN_BIT); }
INLINE real with_sign(real size, real x) { return (real)((mask)size | ((mask)x & SIGN_BIT)); } /* size >= 0 */
INLINE real sign(real x) { return choose(x == 0.0, x, with_sign(same(1.0), x)); }

#endif
