/* REF: the dense extended Kalman filter in C, its plant inlined: what the arithmetic costs where no FMU is called.

   z = [qd, q, chi] (NX), Euler transition (Gautier & Poignet 2001, Eq. 13), forward or central differences by every
   entry of z with the steps of pipeline/plant/steps.py, F P F' + G Q G' and the Joseph form by whole matrices, as
   filterpy does. The plant (PLANT, a header) defines N joints, P parameters and

     static bool accelerations(const double *s, const double *u, const double *chi, double *qdd);
     static void response(const double *s, const double *chi, double J[N][N]);    J = d qdd / d tau, the inverse mass

   The first is false where the mass matrix is not positive definite; J gives G without another evaluation, so that there
   are 1 + NX of them a sample. The sizes are constants, so that the compiler unrolls. */
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include PLANT

#define NS (2 * N)
#define NX (NS + P)
#define ROWS 3
#define COLUMNS 12

typedef double Matrix[NX][NX];

/* C = A B, in tiles of a size that compilers keep in registers: NX is a multiple of 12 for every plant here. */
static void multiply(const Matrix A, const Matrix B, Matrix C) {
    _Static_assert(NX % COLUMNS == 0 && NX % ROWS == 0, "whole tiles");
    for (int i = 0; i < NX; i += ROWS)
        for (int j = 0; j < NX; j += COLUMNS) {
            double tile[ROWS][COLUMNS] = {{0}};
            for (int k = 0; k < NX; k++)
                for (int r = 0; r < ROWS; r++)
                    for (int c = 0; c < COLUMNS; c++) tile[r][c] += A[i + r][k] * B[k][j + c];
            for (int r = 0; r < ROWS; r++) memcpy(&C[i + r][j], tile[r], sizeof tile[r]);
        }
}

/* f = s + dt [qdd, qd] */
static bool transition(const double *restrict z, const double *restrict u, double dt, double *restrict f) {
    double qdd[N];
    if (!accelerations(z, u, z + NS, qdd)) return false;
    for (int i = 0; i < N; i++) f[i] = z[i] + dt * qdd[i];
    for (int i = 0; i < N; i++) f[N + i] = z[N + i] + dt * z[i];
    return true;
}

/* f (NS) and F with its transpose, whose rows are the differences; the parameters' rows of F are the identity's. */
static bool linearise(const double *restrict z, const double *restrict u, double dt, const double *restrict floor,
                      bool central, double *restrict f, Matrix F, Matrix Ft) {
    double there[NX], ahead[NS], behind[NS];
    double epsilon = central ? 1e-5 : 1e-7;
    memcpy(there, z, sizeof there);
    if (!transition(z, u, dt, f)) return false;
    for (int i = 0; i < NX; i++) {
        double step = epsilon * fmax(fabs(z[i]), floor[i]), at = z[i] + step, back = z[i];
        there[i] = at;
        if (!transition(there, u, dt, ahead)) return false;
        if (central) {
            there[i] = back = z[i] - step;
            if (!transition(there, u, dt, behind)) return false;
        }
        there[i] = z[i];
        const double *from = central ? behind : f;
        for (int j = 0; j < NS; j++) F[j][i] = Ft[i][j] = (ahead[j] - from[j]) / (at - back);
    }
    return true;
}

/* z and P over a step of dt; Q (N) are the variances of the joint forces. */
static bool predict(double *restrict z, Matrix cov, const double *restrict u, double dt, const double *restrict Q,
                    const double *restrict floor, bool central, Matrix F, Matrix Ft) {
    static _Thread_local Matrix FP;
    double f[NS], J[N][N];
    if (!linearise(z, u, dt, floor, central, f, F, Ft)) return false;
    response(z, z + NS, J);
    memcpy(z, f, sizeof f);
    multiply(F, cov, FP);
    multiply(FP, Ft, cov);
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) {
            double sum = 0;
            for (int k = 0; k < N; k++) sum += J[i][k] * Q[k] * J[j][k];
            cov[i][j] += dt * dt * sum;
        }
    return true;
}

/* X <- S^-1 X by the Cholesky factor of S, which it overwrites; false where S is not positive definite. */
static bool solve_S(double S[restrict N][N], double X[restrict N][NX]) {
    for (int j = 0; j < N; j++) {
        if (!(S[j][j] > 0)) return false;
        double pivot = 1 / (S[j][j] = sqrt(S[j][j]));
        for (int c = 0; c < NX; c++) X[j][c] *= pivot;
        for (int i = j + 1; i < N; i++) {
            S[i][j] *= pivot;
            for (int k = j + 1; k <= i; k++) S[i][k] -= S[i][j] * S[k][j];
            for (int c = 0; c < NX; c++) X[i][c] -= S[i][j] * X[j][c];
        }
    }
    for (int j = N - 1; j >= 0; j--) {
        double pivot = 1 / S[j][j];
        for (int c = 0; c < NX; c++) X[j][c] *= pivot;
        for (int i = 0; i < j; i++)
            for (int c = 0; c < NX; c++) X[i][c] -= S[j][i] * X[j][c];
    }
    return true;
}

/* The measured positions y (N) with variances R: P = (I - K H) P (I - K H)' + K R K'. */
static bool update(double *restrict z, Matrix cov, const double *restrict y, const double *restrict R) {
    static _Thread_local Matrix L, Lt, LP;
    double S[N][N], Kt[N][NX], innovation[N];
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) S[i][j] = cov[N + i][N + j];
        S[i][i] += R[i];
        innovation[i] = y[i] - z[N + i];
    }
    memcpy(Kt, cov[N], sizeof Kt);
    if (!solve_S(S, Kt)) return false;
    memset(L, 0, sizeof L);
    for (int i = 0; i < NX; i++) L[i][i] = 1;
    for (int m = 0; m < N; m++)
        for (int i = 0; i < NX; i++) {
            z[i] += innovation[m] * Kt[m][i];
            L[i][N + m] -= Kt[m][i];
        }
    for (int i = 0; i < NX; i++)
        for (int j = 0; j < NX; j++) Lt[j][i] = L[i][j];
    multiply(L, cov, LP);
    multiply(LP, Lt, cov);
    for (int i = 0; i < NX; i++)
        for (int m = 0; m < N; m++)
            for (int j = 0; j < NX; j++) cov[i][j] += Kt[m][i] * R[m] * Kt[m][j];
    return true;
}

/* Filter `samples` positions q with inputs u held in between; x and variances (samples, NX) come back.
   z0 (NX), P0 (NX, NX), R and Q (N), floor (NX) of the differences' steps. Returns how many samples were done. */
long ref_ekf(long samples, const double *time, const double *q, const double *u, const double *z0, const double *P0,
             const double *R, const double *Q, const double *floor, int central, double *x, double *variances) {
    static _Thread_local Matrix cov, F, Ft;
    double z[NX];
    memcpy(z, z0, sizeof z);
    memcpy(cov, P0, sizeof cov);
    memset(F, 0, sizeof F);
    for (int i = 0; i < NX; i++) F[i][i] = 1;
    memcpy(Ft, F, sizeof F);
    for (long k = 0; k < samples; k++) {
        double dt = k ? time[k] - time[k - 1] : 0;
        if (k && !predict(z, cov, u + (k - 1) * N, dt, Q, floor, central, F, Ft)) return k;
        if (!update(z, cov, q + k * N, R)) return k;
        memcpy(x + k * NX, z, sizeof z);
        for (int i = 0; i < NX; i++) variances[k * NX + i] = cov[i][i];
    }
    return samples;
}
