/* A planar chain of LINKS links in a vertical plane (modelica: Components.ChainBody), by the links' angles theta:

     sum_j M_ij thetadd_j + h_i = tau_i - tau_i+1,   M_ij = L MX_max(i,j) cos(theta_i - theta_j),  M_ii = ZZ_i
     h_i = sum_j L MX_max(i,j) sin(theta_i - theta_j) thetad_j^2 + g MX_i sin(theta_i)

   M is factorised as U' D U in place, row by row. */
#define N LINKS
#define P (4 * N)
#define EPS 0.1    /* rad/s */
#define LENGTH 0.5 /* m */
#define GRAVITY 9.81

enum { ZZ = 0, MX = N, FV = 2 * N, FS = 3 * N };

/* The upper triangle of M, and h, at the state s. */
static void dynamics(const double *restrict s, const double *restrict chi, double M[N][N], double *restrict h) {
    double c[N], si[N], square[N], theta = 0, omega = 0;
    for (int i = 0; i < N; i++) {
        theta += s[N + i];
        omega += s[i];
        c[i] = cos(theta);
        si[i] = sin(theta);
        square[i] = omega * omega;
        h[i] = GRAVITY * chi[MX + i] * si[i];
    }
    for (int i = 0; i < N; i++) {
        M[i][i] = chi[ZZ + i];
        for (int j = i + 1; j < N; j++) {
            double coupling = LENGTH * chi[MX + j], sine = coupling * (si[i] * c[j] - c[i] * si[j]);
            M[i][j] = coupling * (c[i] * c[j] + si[i] * si[j]);
            h[i] += sine * square[j];
            h[j] -= sine * square[i];
        }
    }
}

/* M = U' D U: U over M's upper triangle with 1 / D on its diagonal; false where M is not positive definite. */
static bool factorise(double M[N][N]) {
    for (int k = 0; k < N; k++) {
        if (!(M[k][k] > 0)) return false;
        double inverse = M[k][k] = 1 / M[k][k];
        for (int i = k + 1; i < N; i++) {
            double factor = M[k][i] * inverse;
            for (int j = i; j < N; j++) M[i][j] -= factor * M[k][j];
        }
    }
    return true;
}

/* x <- M^-1 x for `count` right sides side by side, M factorised. */
static void solve(const double M[restrict N][N], double *restrict x, int count) {
    for (int k = 0; k < N; k++)
        for (int i = k + 1; i < N; i++)
            for (int m = 0; m < count; m++) x[i * count + m] -= M[k][i] * M[k][k] * x[k * count + m];
    for (int k = N - 1; k >= 0; k--) {
        for (int m = 0; m < count; m++) x[k * count + m] *= M[k][k];
        for (int i = 0; i < k; i++)
            for (int m = 0; m < count; m++) x[i * count + m] -= M[i][k] * x[k * count + m];
    }
}

static bool accelerations(const double *restrict s, const double *restrict u, const double *restrict chi,
                          double *restrict qdd) {
    double M[N][N], h[N], tau[N + 1];
    for (int i = 0; i < N; i++) tau[i] = u[i] - (chi[FV + i] * s[i] + chi[FS + i] * tanh(s[i] / EPS));
    tau[N] = 0;
    dynamics(s, chi, M, h);
    for (int i = 0; i < N; i++) qdd[i] = tau[i] - tau[i + 1] - h[i];
    if (!factorise(M)) return false;
    solve(M, qdd, 1);
    for (int i = N - 1; i > 0; i--) qdd[i] -= qdd[i - 1];
    return true;
}

/* J = T M^-1 T', T being the differences of neighbouring links. */
static void response(const double *restrict s, const double *restrict chi, double J[N][N]) {
    double M[N][N], h[N];
    dynamics(s, chi, M, h);
    factorise(M);
    memset(J, 0, N * sizeof *J);
    for (int i = 0; i < N; i++) {
        J[i][i] = 1;
        if (i) J[i - 1][i] = -1;
    }
    solve(M, &J[0][0], N);
    for (int i = N - 1; i > 0; i--)
        for (int j = 0; j < N; j++) J[i][j] -= J[i - 1][j];
}
