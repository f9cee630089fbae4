"""The program of all intervals with its sparse derivatives, from functions of one interval each."""

import casadi
import numpy


class Triplets:
    """Entries of a sparse matrix as pieces of a vector; entries of one place are summed."""

    def __init__(self):
        self.rows, self.columns, self.values = [], [], []

    def add(self, rows, columns, values):
        self.rows += list(rows)
        self.columns += list(columns)
        self.values.append(casadi.vec(values))

    def add_matrix(self, matrix, first_row=0):
        rows, columns = entries(matrix.sparsity())
        self.add(first_row + rows, columns, matrix.nz[:])

    def matrix(self, shape, symmetric=False):
        rows, columns = numpy.array(self.rows, int), numpy.array(self.columns, int)
        if symmetric:  # the upper triangle, as Ipopt takes it
            rows, columns = numpy.minimum(rows, columns), numpy.maximum(rows, columns)

        places, index = numpy.unique(columns * shape[0] + rows, return_inverse=True)
        sparsity = casadi.Sparsity.triplet(
            *shape, (places % shape[0]).tolist(), (places // shape[0]).tolist()
        )
        summed = casadi.Sparsity.triplet(
            len(places), len(index), index.tolist(), list(range(len(index)))
        )
        values = casadi.mtimes(casadi.DM(summed, 1.0), casadi.vertcat(*self.values))
        return casadi.MX(sparsity, values)


def entries(sparsity):
    rows, columns = sparsity.get_triplet()
    return numpy.array(rows, int), numpy.array(columns, int)


class Assembly:
    """CasADi's program in y, variables over their scales, with derivatives of its own."""

    def __init__(self, program, rows):
        self.program, self.scale = program, numpy.array(program.scale)
        self.size, self.rows, self.at = len(program.scale), rows, 0
        self.y, self.factor = casadi.MX.sym("y", self.size), casadi.MX.sym("factor")
        self.multipliers = casadi.MX.sym("multipliers", rows)
        self.cost, self.cost_again, self.lagrangian = casadi.MX(0.0), casadi.MX(0.0), casadi.MX(0.0)
        self.g, self.g_again, self.lower, self.upper = [], [], [], []
        self.slope, self.first, self.second = Triplets(), Triplets(), Triplets()

    @property
    def x(self):
        return self.y * casadi.DM(self.scale)

    def add_rows(self, rows, value, again, several=1):
        self.g.append(casadi.vec(value))
        self.g_again.append(casadi.vec(again))
        self.lower += list(numpy.array(rows.lower) / rows.scale) * several
        self.upper += list(numpy.array(rows.upper) / rows.scale) * several
        self.at += value.numel()

    def add_intervals(self, interval, columns, fractions):
        """Intervals of one kind: `columns` of each one's variables."""
        several, count = len(columns), interval.values.size1_out(0)
        columns = numpy.array(columns)
        inputs = self._inputs(interval, columns, fractions)
        rows, cost = interval.values.map(several)(*inputs)
        again, cost_again, jacobian, gradient = interval.first.map(several)(*inputs)
        multipliers = casadi.reshape(
            self.multipliers[self.at : self.at + count * several], count, several
        )
        factors = casadi.repmat(self.factor, 1, several)
        hessian = interval.second.map(several)(*inputs, factors, multipliers)

        self.cost += casadi.sum2(cost)
        self.cost_again += casadi.sum2(cost_again)
        flat = columns.ravel()
        self.slope.add(flat, 0 * flat, casadi.vec(gradient) * casadi.DM(self.scale[flat]))

        r, c = entries(interval.first.sparsity_out(2))
        places = numpy.concatenate([self.at + i * count + r for i in range(several)])
        columns_c = columns[:, c].ravel()
        self.first.add(places, columns_c, jacobian.nz[:] * casadi.DM(self.scale[columns_c]))

        r, c = entries(interval.second.sparsity_out(0))
        r, c = columns[:, r].ravel(), columns[:, c].ravel()
        self.second.add(r, c, hessian.nz[:] * casadi.DM(self.scale[r] * self.scale[c]))
        self.add_rows(interval.rows, rows, again, several)

    def _inputs(self, interval, columns, fractions):
        sizes = [interval.values.size1_in(i) for i in range(interval.values.n_in() - 1)]
        inputs = []
        for part in numpy.split(columns, numpy.cumsum(sizes)[:-1], axis=1):
            flat = part.ravel()
            values = self.y[flat.tolist()] * casadi.DM(self.scale[flat])
            inputs.append(casadi.reshape(values, part.shape[1], len(columns)))
        return inputs + [casadi.DM(fractions).T]

    def add_node_rows(self, rows):
        value = rows.value / casadi.DM(rows.scale)
        multipliers = self.multipliers[self.at : self.at + value.numel()]
        self.lagrangian += casadi.dot(multipliers, value)
        self.first.add_matrix(casadi.jacobian(value, self.y), self.at)
        self.add_rows(rows, value, value)

    def add_objective(self, objective):
        self.cost += objective
        self.cost_again += objective
        self.lagrangian += self.factor * objective
        self.slope.add_matrix(casadi.jacobian(objective, self.y).T)

    def derivatives(self):
        assert self.at == self.rows
        self.second.add_matrix(casadi.triu(casadi.hessian(self.lagrangian, self.y)[0]))
        y, p, size = self.y, casadi.MX.sym("p", 0), self.size
        gradient = casadi.densify(self.slope.matrix((size, 1)))
        jacobian = self.first.matrix((self.at, size))
        hessian = self.second.matrix((size, size), symmetric=True)
        given, names = [y, p, self.factor, self.multipliers], ["x", "p", "lam_f", "lam_g"]
        rows = casadi.vertcat(*self.g_again)
        return {
            "grad_f": casadi.Function(
                "nlp_grad_f", given[:2], [self.cost_again, gradient], names[:2], ["f", "grad_f_x"]
            ),
            "jac_g": casadi.Function(
                "nlp_jac_g", given[:2], [rows, jacobian], names[:2], ["g", "jac_g_x"]
            ),
            "hess_lag": casadi.Function(
                "nlp_hess_l", given, [hessian], names, ["triu_hess_gamma_x_x"]
            ),
        }

    def program_of(self):
        return {
            "start": self.program.start,
            "nlp": {"x": self.y, "f": self.cost, "g": casadi.vertcat(*self.g)},
            "derivatives": self.derivatives(),
            "scale": self.scale,
            "lbg": self.lower,
            "ubg": self.upper,
            "lbx": numpy.array(self.program.lower) / self.scale,
            "ubx": numpy.array(self.program.upper) / self.scale,
        }
