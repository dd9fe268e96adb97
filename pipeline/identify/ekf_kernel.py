"""The extended Kalman filter over a record, compiled: the structure F = [A B; 0 I] used, the plant by its kernels.

The same filter as `ekf.py`, with both forms of the covariance; all arrays by address, in a record.
"""

from __future__ import annotations

from math import isfinite, sqrt

from pipeline.plant.kernel import array_at, kernel, matrix_at
from pipeline.plant.transition_kernel import linearise

FILTER = [
    *((name, "i8") for name in (
        "n", "ns", "p", "nq", "udu", "input_noise", "mode", "central",
        # the record: time (N,), q and u (N, n), gain and R (n,), variances of the process noise (nq,)
        "time", "q", "u", "gain", "R", "noise",
        # what goes from sample to sample: z (nx,), and P (nx, nx) or its factors U (nx, nx) and d (nx,)
        "z", "P", "d",
        # what is found: (N, nx), (N, nx), (N, n), (N, n), (N,)
        "x", "P_diag", "innovation", "S_diag", "NIS",
        # room to work in, shapes in ekf_compiled.py
        "f", "J", "G", "T", "W", "weight", "S", "L", "K", "Ph", "M", "v",
    )),
    ("epsilon", "f8"),
]  # fmt: skip
"""Fields of the record of a filter."""

DONE, PLANT_FAILED, NO_MASS, NOT_FINITE, NOT_POSITIVE = range(5)
"""What a run ends with."""

TINY = 1e-150
"""Smaller entries are 0: their products would be denormal, and those take six times as long."""


@kernel
def cholesky(S, L, n):
    """S = L Lᵀ (n, n): whether S is positive definite."""
    for i in range(n):
        for j in range(i + 1):
            value = S[i, j]
            for k in range(j):
                value -= L[i, k] * L[j, k]
            if i == j:
                if not value > 0.0:
                    return False
                L[i, i] = sqrt(value)
            else:
                L[i, j] = value / L[j, j]
    return True


@kernel
def _process_noise(w):
    """G (ns, nq) by J's rows of u, where the noise is on the forces; whether a force pushes its own way.

    ∂qd⁺/∂tau (n, n) ≈ M⁻¹ dt must be positive: the FMU rejects no parameter that a filter may ask for.
    """
    n, ns, nx = w.n, w.ns, w.ns + w.p
    J, gain = matrix_at(w.J, nx + n, ns), array_at(w.gain, n)
    S, G = matrix_at(w.S, n, n), matrix_at(w.G, ns, w.nq)
    for j in range(n):
        for i in range(n):
            S[i, j] = J[nx + j, i] / gain[j] + J[nx + i, j] / gain[i]
    if w.input_noise:
        for j in range(n):
            for i in range(ns):
                G[i, j] = J[nx + j, i] / gain[j]
    return cholesky(S, matrix_at(w.L, n, n), n)


@kernel
def _predict_joseph(w):
    """P ← F P Fᵀ + G diag(q) Gᵀ; of P only the rows and columns of the states change."""
    ns, nx = w.ns, w.ns + w.p
    P, J, T = matrix_at(w.P, nx, nx), matrix_at(w.J, nx + w.n, ns), matrix_at(w.T, ns, nx)
    G, noise = matrix_at(w.G, ns, w.nq), array_at(w.noise, w.nq)
    for i in range(ns):  # T = [A B] P
        for k in range(nx):
            T[i, k] = 0.0
        for j in range(nx):
            a = J[j, i]
            if a != 0.0:
                for k in range(nx):
                    T[i, k] += a * P[j, k]
    for i in range(ns):
        for j in range(i + 1):
            P[i, j] = 0.0
        for k in range(nx):
            for j in range(i + 1):
                P[i, j] += T[i, k] * J[k, j]
        for k in range(w.nq):
            a = G[i, k] * noise[k]
            for j in range(i + 1):
                P[i, j] += a * G[j, k]
        for k in range(ns, nx):
            P[i, k] = P[k, i] = T[i, k]
    for i in range(ns):
        for j in range(i):
            P[j, i] = P[i, j]


@kernel
def _predict_udu(w):
    """The factors of F P Fᵀ + G diag(q) Gᵀ by Thornton's Gram–Schmidt, which leaves those of the parameters alone.

    F U = [A Us, A Usp + B Up; 0, Up]: the last columns are those of the new U as they are, and the rows of the states
    are made orthogonal over what is left, W = [A Us, G]. U and W stand transposed.
    """
    ns, nx, nq = w.ns, w.ns + w.p, w.nq
    U, d, J, T = matrix_at(w.P, nx, nx), array_at(w.d, nx), matrix_at(w.J, nx + w.n, ns), matrix_at(w.T, nx, ns)
    for k in range(nx):  # T = (F U)ᵀ, for the rows of the states
        for i in range(ns):
            T[k, i] = 0.0
        for j in range(k + 1):
            a = U[k, j]
            for i in range(ns):
                T[k, i] += a * J[j, i]
    for k in range(ns, nx):
        for i in range(ns):
            U[k, i] = T[k, i]
    G, W, weight = matrix_at(w.G, ns, nq), matrix_at(w.W, ns + nq, ns), array_at(w.weight, ns + nq)
    noise = array_at(w.noise, nq)
    for i in range(ns):
        weight[i] = d[i]
        for k in range(ns):
            W[k, i] = T[k, i]
        for k in range(nq):
            W[ns + k, i] = G[i, k]
    for k in range(nq):
        weight[ns + k] = noise[k]
    for j in range(ns - 1, -1, -1):
        _orthogonal(w, U, W, weight, d, j)


@kernel
def _orthogonal(w, U, W, weight, d, j):
    """d[j] and column j of U; what the rows of W above j have of row j is taken off."""
    d[j] = 0.0
    for i in range(j):
        U[j, i] = 0.0
    for k in range(w.ns + w.nq):
        v = weight[k] * W[k, j]
        d[j] += W[k, j] * v
        for i in range(j):
            U[j, i] += W[k, i] * v
    if not d[j] > 0.0:
        for i in range(j):
            U[j, i] = 0.0
        return
    for i in range(j):
        U[j, i] /= d[j]
    for k in range(w.ns + w.nq):
        for i in range(j):
            W[k, i] -= U[j, i] * W[k, j]


@kernel
def _innovate(w, k):
    """The innovation of sample k from S; NIS = rᵀ S⁻¹ r. Whether S is positive definite."""
    n, ns = w.n, w.ns
    S, L, v, z = matrix_at(w.S, n, n), matrix_at(w.L, n, n), array_at(w.v, n), array_at(w.z, ns)
    q, found = array_at(w.q + 8 * k * n, n), array_at(w.innovation + 8 * k * n, n)
    S_diag, NIS = array_at(w.S_diag + 8 * k * n, n), 0.0
    if not cholesky(S, L, n):
        return False
    for i in range(n):
        found[i], S_diag[i] = q[i] - z[n + i], S[i, i]
        v[i] = found[i]
        for j in range(i):
            v[i] -= L[i, j] * v[j]
        v[i] /= L[i, i]
        NIS += v[i] * v[i]
    array_at(w.NIS, k + 1)[k] = NIS
    return True


@kernel
def _update_joseph(w, k):
    """P ← (I − K h) P (I − K h)ᵀ + K r Kᵀ and z with it, for one position after the other."""
    n, nx = w.n, w.ns + w.p
    P, S, R, M = matrix_at(w.P, nx, nx), matrix_at(w.S, n, n), array_at(w.R, n), matrix_at(w.M, nx, nx)
    K, Ph, z, q = array_at(w.K, nx), array_at(w.Ph, nx), array_at(w.z, nx), array_at(w.q + 8 * k * n, n)
    for i in range(n):
        for j in range(n):
            S[i, j] = P[n + i, n + j]
        S[i, i] += R[i]
    if not _innovate(w, k):
        return False
    for i in range(n):
        h = n + i
        variance, residual = P[h, h] + R[i], q[i] - z[h]
        for a in range(nx):
            Ph[a] = P[h, a]
            K[a] = Ph[a] / variance
            z[a] += K[a] * residual
        for a in range(nx):
            for b in range(nx):
                M[a, b] = P[a, b] - K[a] * Ph[b]
        for a in range(nx):
            factor = K[a] * R[i] - M[a, h]
            for b in range(a + 1):
                value = M[a, b] + factor * K[b]
                P[a, b] = 0.0 if abs(value) < TINY and b < a else value
        for a in range(nx):
            for b in range(a):
                P[b, a] = P[a, b]
    for a in range(nx):
        if not P[a, a] > 0.0:
            return False
    return True


@kernel
def _update_udu(w, k):
    """Bierman's update by one position after the other, and z with it. U stands transposed."""
    n, nx = w.n, w.ns + w.p
    U, d, R, S = matrix_at(w.P, nx, nx), array_at(w.d, nx), array_at(w.R, n), matrix_at(w.S, n, n)
    z, q, b = array_at(w.z, nx), array_at(w.q + 8 * k * n, n), array_at(w.K, nx)
    for i in range(n):
        for j in range(i + 1):
            S[i, j] = 0.0
            for a in range(n + i, nx):
                S[i, j] += U[a, n + i] * d[a] * U[a, n + j]
            S[j, i] = S[i, j]
        S[i, i] += R[i]
    if not _innovate(w, k):
        return False
    for i in range(n):
        residual, alpha = q[i] - z[n + i], R[i]
        for a in range(nx):
            b[a] = 0.0
        for a in range(n + i, nx):
            f, before = U[a, n + i], alpha
            v, factor = d[a] * f, f / before
            alpha += f * v
            d[a] *= before / alpha
            for c in range(a):
                kept = U[a, c]
                U[a, c] = kept - b[c] * factor
                b[c] += v * kept
            b[a] += v
        for a in range(nx):
            z[a] += b[a] / alpha * residual
    return True


@kernel
def _note(w, k):
    """Sample k's estimate and the diagonal of its covariance; whether both are finite."""
    nx = w.ns + w.p
    z, P, d = array_at(w.z, nx), matrix_at(w.P, nx, nx), array_at(w.d, nx)
    x, P_diag = array_at(w.x + 8 * k * nx, nx), array_at(w.P_diag + 8 * k * nx, nx)
    total = array_at(w.NIS, k + 1)[k]
    for a in range(nx):
        P_diag[a] = 0.0 if w.udu else P[a, a]
    if w.udu:
        for b in range(nx):
            for a in range(b + 1):
                P[b, a] = 0.0 if abs(P[b, a]) < TINY else P[b, a]
                P_diag[a] += P[b, a] * P[b, a] * d[b]
    for a in range(nx):
        x[a] = z[a]
        total += x[a] + P_diag[a]
    return isfinite(total)


@kernel
def _predict(m, w, k):
    """z and its covariance at sample k, from those at k − 1."""
    ns, nx = w.ns, w.ns + w.p
    time, z, f = array_at(w.time, k + 1), array_at(w.z, nx), array_at(w.f, ns)
    t, u = time[k - 1], w.u + 8 * (k - 1) * w.n
    if linearise(m, w.z, u, w.z + 8 * ns, t, time[k] - t, w.mode, w.epsilon, w.central, w.f, w.J):
        return PLANT_FAILED
    if not _process_noise(w):
        return NO_MASS
    for i in range(ns):
        z[i] = f[i]
    if w.udu:
        _predict_udu(w)
    else:
        _predict_joseph(w)
    return DONE


@kernel
def run(plant, filter, first, end):
    """Filter samples first … end − 1; gives the sample reached, and what the run ended with."""
    m, w = plant[0], filter[0]
    for k in range(first, end):
        if k > 0:
            reason = _predict(m, w, k)
            if reason != DONE:
                return k, reason
        if not (_update_udu(w, k) if w.udu else _update_joseph(w, k)):
            return k, NOT_POSITIVE
        if not _note(w, k):
            return k, NOT_FINITE
    return end, DONE
