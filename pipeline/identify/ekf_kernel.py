"""The extended Kalman filter over a record, compiled: the structure F = [A B; 0 I] used, the plant by its kernels.

The same filter as `ekf.py`, with both forms of the covariance. The arrays of the filter's record have the plant's own
sizes, which are constants of the machine code; what grows with the samples stands at an address.
"""

from __future__ import annotations

from math import isfinite

from pipeline.plant.kernel import array_at, kernel
from pipeline.plant.linearise_kernel import linearise
from pipeline.plant.row_kernel import column, row, set_row, symmetric_row, unit_row, without_tiny, zero_row


def filter_fields(n: int, ns: int, p: int, nq: int) -> list[tuple]:
    """Fields of the record of a filter: n measured positions, ns states, p parameters, nq variances of process noise.

    Of the data time (N,), q, u (N, n); of the result x, P_diag (N, nx), innovation, S_diag (N, n), NIS (N,). From
    sample to sample: z (nx,) and P (nx, nx), or its factors Uᵀ, as P, and d. The rest is room to work in.
    """
    nx = ns + p
    addresses = ("stop", "time", "q", "u", "x", "P_diag", "innovation", "S_diag", "NIS")
    arrays = {
        "R": (n,), "noise": (nq,), "z": (nx,), "P": (nx, nx), "d": (nx,), "G": (nq, ns), "T": (ns, nx),
        "W": (ns + nq, ns), "weight": (ns + nq,), "S": (n, n), "L": (n, n), "K": (nx,), "back": (nx,),
        "diagonal": (nx,),
        "v": (n,),
    }  # fmt: skip
    return [
        *((name, "i8") for name in ("udu", "input_noise", "mode", "central", *addresses)),
        ("epsilon", "f8"),
        *((name, "f8", shape) for name, shape in arrays.items()),
    ]


DONE, PLANT_FAILED, NO_MASS, NOT_FINITE, NOT_POSITIVE, STOPPED = range(6)
"""What a run ends with."""

TINY = 1e-150
"""Smaller entries are 0: their products would be denormal, and those take six times as long."""


@kernel
def factor(S, L):
    """S = L D Lᵀ, L unit lower triangular but for D on its diagonal: whether S is positive definite."""
    for i in range(S.shape[0]):
        pivot = S[i, i]
        for j in range(i):
            value = S[i, j]
            for k in range(j):
                value -= L[i, k] * L[k, k] * L[j, k]
            L[i, j] = value / L[j, j]
            pivot -= L[i, j] * value
        L[i, i] = pivot
        if not pivot > 0.0:
            return False
    return True


@kernel
def _process_noise(m, w):
    """G (ns, nq) by J's rows of u, where the noise is on the forces; whether a force pushes its own way.

    ∂qd⁺/∂tau (n, n) ≈ M⁻¹ dt must be positive: the FMU rejects no parameter that a filter may ask for.
    """
    n, nx, J, gain, S = w.R.shape[0], w.z.shape[0], m.J, m.gain, w.S
    for j in range(n):
        for i in range(n):
            S[i, j] = J[nx + j, i] / gain[j] + J[nx + i, j] / gain[i]
    if w.input_noise:
        for j in range(n):
            for i in range(w.G.shape[1]):
                w.G[j, i] = J[nx + j, i] / gain[j]
    return factor(S, w.L)


@kernel
def _predict_joseph(m, w):
    """P ← F P Fᵀ + G diag(q) Gᵀ in P's lower triangle, of which only the columns of the states change."""
    P, J, T, G, noise = w.P, m.J, w.T, w.G, w.noise
    ns, nx = T.shape
    for i in range(ns):  # T = [A B] P
        t = zero_row(T)
        for j in range(nx):
            a = J[j, i]
            if a != 0.0:
                t += a * row(P, j)
        set_row(T, i, t)
    for i in range(ns):
        p = zero_row(J)
        for k in range(nx):
            p += T[i, k] * row(J, k)
        for k in range(noise.shape[0]):
            p += G[k, i] * noise[k] * row(G, k)
        set_row(P, i, p)
    for k in range(ns, nx):
        set_row(P, k, column(T, k))


@kernel
def _predict_udu(m, w):
    """The factors of F P Fᵀ + G diag(q) Gᵀ by Thornton's Gram–Schmidt, which leaves those of the parameters alone.

    F U = [A Us, A Usp + B Up; 0, Up]: the last columns are those of the new U as they are, and the rows of the states
    are made orthogonal over what is left, W = [A Us, G]. U and W stand transposed.
    """
    U, d, J, W, weight, G = w.P, w.d, m.J, w.W, w.weight, w.G
    nx, ns = w.z.shape[0], m.f.shape[0]
    for k in range(nx):
        fu = zero_row(J)
        for j in range(k + 1):
            fu += U[k, j] * row(J, j)
        if k < ns:
            set_row(W, k, fu)
        else:
            set_row(U, k, fu)
    for i in range(ns):
        weight[i] = d[i]
    for k in range(G.shape[0]):
        set_row(W, ns + k, row(G, k))
    for k in range(G.shape[0]):
        weight[ns + k] = w.noise[k]
    for j in range(ns - 1, -1, -1):
        _orthogonal(U, W, weight, d, j)


@kernel
def _orthogonal(U, W, weight, d, j):
    """d[j] and column j of U; what the rows of W above j have of row j is taken off. Those from j on are done with."""
    u, length = zero_row(W), 0.0
    for k in range(W.shape[0]):
        v = weight[k] * W[k, j]
        length += W[k, j] * v
        u += v * row(W, k)
    d[j] = length
    if not length > 0.0:
        set_row(U, j, unit_row(zero_row(W), j))
        return
    u = unit_row(u / length, j)
    set_row(U, j, u)
    for k in range(W.shape[0]):
        set_row(W, k, row(W, k) - u * W[k, j])


@kernel
def _innovate(w, k):
    """The innovation of sample k from S; NIS = rᵀ S⁻¹ r. Whether S is positive definite."""
    S, L, v, z, n = w.S, w.L, w.v, w.z, w.R.shape[0]
    q, found = array_at(w.q + 8 * k * n, n), array_at(w.innovation + 8 * k * n, n)
    S_diag, NIS = array_at(w.S_diag + 8 * k * n, n), 0.0
    if not factor(S, L):
        return False
    for i in range(n):
        found[i], S_diag[i] = q[i] - z[n + i], S[i, i]
        v[i] = found[i]
        for j in range(i):
            v[i] -= L[i, j] * v[j]
        NIS += v[i] * v[i] / L[i, i]
    array_at(w.NIS, k + 1)[k] = NIS
    return True


@kernel
def _update_joseph(w, k):
    """P ← (I − K h) P (I − K h)ᵀ + K r Kᵀ and z with it, for one position after the other.

    Of P the lower triangle counts; the upper one is made its mirror image in the end.
    """
    P, S, R, K, back, z = w.P, w.S, w.R, w.K, w.back, w.z
    n, nx = R.shape[0], z.shape[0]
    q = array_at(w.q + 8 * k * n, n)
    for i in range(n):
        for j in range(n):
            S[i, j] = P[n + max(i, j), n + min(i, j)]
        S[i, i] += R[i]
    if not _innovate(w, k):
        return False
    for i in range(n):
        h = n + i
        variance, residual = P[h, h] + R[i], q[i] - z[h]
        Ph = symmetric_row(P, h)
        gain = Ph * (1.0 / variance)
        set_row(K, 0, gain)
        set_row(back, 0, gain * R[i] - (Ph - gain * P[h, h]))
        set_row(z, 0, row(z, 0) + gain * residual)
        for a in range(nx):
            set_row(P, a, row(P, a) - K[a] * Ph + back[a] * gain)
    for a in range(nx):
        for b in range(a):
            P[a, b] = P[b, a] = 0.0 if abs(P[a, b]) < TINY else P[a, b]
    for a in range(nx):
        if not P[a, a] > 0.0:
            return False
    return True


@kernel
def _update_udu(w, k):
    """Bierman's update by one position after the other, and z with it. U stands transposed."""
    U, d, R, S, z = w.P, w.d, w.R, w.S, w.z
    n, nx = R.shape[0], z.shape[0]
    q = array_at(w.q + 8 * k * n, n)
    for i in range(n):
        for j in range(i + 1):
            value = 0.0
            for a in range(n + i, nx):
                value += U[a, n + i] * d[a] * U[a, n + j]
            S[i, j] = S[j, i] = value
        S[i, i] += R[i]
    if not _innovate(w, k):
        return False
    for i in range(n):
        residual, alpha = q[i] - z[n + i], R[i]
        b = zero_row(U)
        for a in range(n + i, nx):
            f, before = U[a, n + i], alpha
            v, factor = d[a] * f, f / before
            alpha += f * v
            d[a] *= before / alpha
            kept = row(U, a)
            set_row(U, a, kept - b * factor)
            b += v * kept
        set_row(z, 0, row(z, 0) + b / alpha * residual)
    return True


@kernel
def _note(w, k):
    """Sample k's estimate and the diagonal of its covariance; whether both are finite."""
    z, P, d, nx = w.z, w.P, w.d, w.z.shape[0]
    x, P_diag = array_at(w.x + 8 * k * nx, nx), array_at(w.P_diag + 8 * k * nx, nx)
    total = array_at(w.NIS, k + 1)[k]
    if w.udu:
        diagonal = zero_row(P)
        for b in range(nx):
            u = without_tiny(row(P, b), TINY)
            set_row(P, b, u)
            diagonal += u * u * d[b]
        set_row(w.diagonal, 0, diagonal)
    else:
        for a in range(nx):
            w.diagonal[a] = P[a, a]
    for a in range(nx):
        x[a], P_diag[a] = z[a], w.diagonal[a]
        total += x[a] + P_diag[a]
    return isfinite(total)


@kernel
def _predict(m, w, k):
    """z and its covariance at sample k, from those at k − 1."""
    n, nx, ns, z, point = w.R.shape[0], w.z.shape[0], m.f.shape[0], w.z, m.point
    time, u = array_at(w.time, k + 1), array_at(w.u + 8 * (k - 1) * n, n)
    for i in range(nx):
        point[i] = z[i]
    for i in range(n):
        point[nx + i] = u[i]
    if linearise(m, time[k - 1], time[k] - time[k - 1], w.mode, w.epsilon, w.central):
        return PLANT_FAILED
    if not _process_noise(m, w):
        return NO_MASS
    for i in range(ns):
        z[i] = m.f[i]
    if w.udu:
        _predict_udu(m, w)
    else:
        _predict_joseph(m, w)
    return DONE


@kernel
def run(plant, filter, first, end):
    """Filter samples first … end − 1; gives the sample reached, and what the run ended with."""
    m, w = plant[0], filter[0]
    for k in range(first, end):
        if array_at(w.stop, 1)[0] != 0.0:
            return k, STOPPED
        if k > 0:
            reason = _predict(m, w, k)
            if reason != DONE:
                return k, reason
        if not (_update_udu(w, k) if w.udu else _update_joseph(w, k)):
            return k, NOT_POSITIVE
        if not _note(w, k):
            return k, NOT_FINITE
    return end, DONE
