/* What plain C can do: the Taylor series of (x1, x2, s, p = s^-4), a vector of orbits at a time. Vector extensions of gcc and
   clang, no intrinsics: the compiler lowers them to what the machine has.

     usage: taylor START STATES SAMPLES REPEATS TOLERANCE C W
     reads x1 and x2 of all samples, writes those at 0.5, 1, 1.5 and 2 yr, prints median seconds: CPU time on 1 thread, wall time on 2. */
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#ifndef ORDER
#define ORDER 14
#endif
#ifdef __AVX512F__
#define WIDTH 8
#else
#define WIDTH 4
#endif
#define PAIR (16 / WIDTH)
#define LANES 16
/* Unrolled, so that sums stay in registers. */
#define EACH _Pragma("GCC unroll 4") for (int u = 0; u < PAIR; u++)

typedef double vec __attribute__((vector_size(8 * WIDTH)));
typedef long long ivec __attribute__((vector_size(8 * WIDTH)));
typedef vec row[PAIR];

static double C, W;

/* a^exponent, good enough for a step: logarithm and power of two by parabolas on the bits. */
static inline vec power(vec a, double exponent) {
    ivec upper = (ivec)a >> 32;
    vec log = __builtin_convertvector(upper, vec) / 1048576.0 - 1023.0;
    vec fraction = __builtin_convertvector(upper & 0xfffff, vec) / 1048576.0;
    log += 0.343 * fraction * (1.0 - fraction);
    vec target = log * exponent;
    ivec whole = __builtin_convertvector(target + 1024.0, ivec) - 1024; /* positive, so this is the floor */
    vec rest = target - __builtin_convertvector(whole, vec);
    return (vec)((whole + 1023) << 52) * (1.0 + rest * (1.0 - 0.337 * (1.0 - rest)));
}

static inline vec choose(ivec mask, vec a, vec b) { return (vec)((mask & (ivec)a) | (~mask & (ivec)b)); }
static inline vec larger(vec a, vec b) { return choose(a > b, a, b); }
static inline vec smaller(vec a, vec b) { return choose(a < b, a, b); }
static inline vec size(vec a) { return (vec)((ivec)a & 0x7fffffffffffffffLL); }

/* Moves LANES orbits through the four snapshots. */
static void follow(const double *x1_0, const double *x2_0, double *out, size_t samples, double reach) {
    row x1[ORDER + 1], x2[ORDER + 1], s[ORDER + 1], p[ORDER + 1], left;
    memcpy(x1[0], x1_0, sizeof(row));
    memcpy(x2[0], x2_0, sizeof(row));
    for (int l = 0; l < LANES; l++)
        ((double *)s[0])[l] = sqrt(1 - x1_0[l] * x1_0[l] - x2_0[l] * x2_0[l]);
    for (int snapshot = 0; snapshot < 4; snapshot++) {
        EACH left[u] = (vec){} + M_PI;
        for (int moving = 1; moving;) {
            row inverse;
            EACH {
                inverse[u] = 1.0 / s[0][u];
                vec square = inverse[u] * inverse[u];
                p[0][u] = square * square;
            }
            for (int n = 0; n < ORDER; n++) {
                row a, b, c;
                EACH {
                    s[n + 1][u] = x1[n][u] * (-C / (n + 1));
                    a[u] = b[u] = c[u] = (vec){};
                }
                for (int j = 0; j <= n; j++)
                    EACH {
                        a[u] += x1[j][u] * p[n - j][u];
                        b[u] += x2[j][u] * p[n - j][u];
                        c[u] += s[j + 1][u] * p[n - j][u];
                    }
                EACH {
                    x1[n + 1][u] = (W * b[u] + (C * s[n][u] - x2[n][u])) * (1.0 / (n + 1));
                    x2[n + 1][u] = (x1[n][u] - W * a[u]) * (1.0 / (n + 1));
                    p[n + 1][u] = inverse[u] * (3 * C / (n + 1) * a[u] - c[u]);
                }
            }
            moving = 0;
            EACH {
                vec last = power(larger(size(x1[ORDER][u]), size(x2[ORDER][u])) + 1e-100, -1.0 / ORDER);
                vec before = power(larger(size(x1[ORDER - 1][u]), size(x2[ORDER - 1][u])) + 1e-100, -1.0 / (ORDER - 1));
                vec step = smaller(reach * smaller(last, before), left[u]);
                left[u] -= step;
                vec y1 = x1[ORDER][u], y2 = x2[ORDER][u], y3 = s[ORDER][u];
                for (int n = ORDER - 1; n >= 0; n--) {
                    y1 = y1 * step + x1[n][u];
                    y2 = y2 * step + x2[n][u];
                    y3 = y3 * step + s[n][u];
                }
                x1[0][u] = y1, x2[0][u] = y2, s[0][u] = y3;
                for (int l = 0; l < WIDTH; l++) moving |= left[u][l] > 0;
            }
        }
        memcpy(out + 2 * snapshot * samples, x1[0], sizeof(row));
        memcpy(out + (2 * snapshot + 1) * samples, x2[0], sizeof(row));
    }
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a - *(const double *)b;
    return (x > 0) - (x < 0);
}

int main(int count, char **argument) {
    if (count != 8) return fprintf(stderr, "usage: taylor START STATES SAMPLES REPEATS TOLERANCE C W\n"), 2;
    long samples = atol(argument[3]), repeats = atol(argument[4]);
    double reach = pow(atof(argument[5]), 1.0 / ORDER);
    C = atof(argument[6]), W = atof(argument[7]);
    double *start = malloc(16 * samples), *out = malloc(64 * samples), *seconds = malloc(8 * repeats);
    FILE *file = fopen(argument[1], "rb");
    if (!file || samples % LANES || fread(start, 16, samples, file) != (size_t)samples) return perror(argument[1]), 1;
    fclose(file);
    for (int threads = 1; threads <= 2; threads++) {
        for (long r = 0; r < repeats; r++) {
            double wall = omp_get_wtime();
            clock_t cpu = clock();
#pragma omp parallel for num_threads(threads) schedule(dynamic, 64)
            for (long i = 0; i < samples / LANES; i++)
                follow(start + i * LANES, start + samples + i * LANES, out + i * LANES, samples, reach);
            seconds[r] = threads == 1 ? (double)(clock() - cpu) / CLOCKS_PER_SEC : omp_get_wtime() - wall;
        }
        qsort(seconds, repeats, 8, ascending);
        printf("%d,%g\n", threads, seconds[repeats / 2]);
    }
    file = fopen(argument[2], "wb");
    return !file || fwrite(out, 64, samples, file) != (size_t)samples || fclose(file);
}
