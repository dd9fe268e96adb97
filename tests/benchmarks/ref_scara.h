/* The two-joint SCARA robot: M(q) qdd = tau - C(q, qd) - friction (modelica: Components.TwoLinkBody, JointFriction). */
#define N 2
#define P 8
#define EPS 0.01 /* rad/s: the width of tanh(qd/eps) while the filter runs (fmus/scara.toml) */

enum { ZZR1, FV1, FS1, ZZ2, LMX2, LMY2, FV2, FS2 };

static bool accelerations(const double *restrict s, const double *restrict u, const double *restrict chi,
                          double *restrict qdd) {
    double qd1 = s[0], qd2 = s[1], c2 = cos(s[3]), s2 = sin(s[3]);
    double a = chi[LMX2] * c2 - chi[LMY2] * s2, b = chi[LMX2] * s2 + chi[LMY2] * c2;
    double M11 = chi[ZZR1] + chi[ZZ2] + 2 * a, M12 = chi[ZZ2] + a, M22 = chi[ZZ2];
    double r1 = u[0] - (chi[FV1] * qd1 + chi[FS1] * tanh(qd1 / EPS)) + b * qd2 * (2 * qd1 + qd2);
    double r2 = u[1] - (chi[FV2] * qd2 + chi[FS2] * tanh(qd2 / EPS)) - b * qd1 * qd1;
    double determinant = M11 * M22 - M12 * M12;
    qdd[0] = (M22 * r1 - M12 * r2) / determinant;
    qdd[1] = (M11 * r2 - M12 * r1) / determinant;
    return determinant > 0 && M22 > 0;
}

static void response(const double *restrict s, const double *restrict chi, double J[N][N]) {
    double a = chi[LMX2] * cos(s[3]) - chi[LMY2] * sin(s[3]);
    double M11 = chi[ZZR1] + chi[ZZ2] + 2 * a, M12 = chi[ZZ2] + a, M22 = chi[ZZ2];
    double determinant = M11 * M22 - M12 * M12;
    J[0][0] = M22 / determinant;
    J[1][1] = M11 / determinant;
    J[0][1] = J[1][0] = -M12 / determinant;
}
