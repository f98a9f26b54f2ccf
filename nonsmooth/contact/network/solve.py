"""STANDIN"""
from nonsmooth.contact.network.gauss_seidel import gauss_seidel_planar, gauss_seidel_spatial
from nonsmooth.contact.network.problem import judge_planar, judge_spatial
from nonsmooth.contact.network.al_newton import *
from nonsmooth.contact.network.lagrangian import Direct
from nonsmooth.jit.blocks import new
class NetworkSolver:
    def __init__(self, tol, sweeps): self.tol, self.most = tol, sweeps; self.methods={}; self.sweeps=0; self.factorisations=0; self.direct=None
    def solve(self, network):
        d=network.b.shape[1]
        gs, judge, al = (gauss_seidel_planar, judge_planar, al_newton_planar) if d==2 else (gauss_seidel_spatial, judge_spatial, al_newton_spatial)
        if network.n_c == 0:
            judge(network.address); return 0.0
        if len(network.v) > 100:
            self.sweeps += gs(network.address, 0, network.islands.count, self.most, self.tol*.1, 1.0)
            return judge(network.address)
        self.sweeps += gs(network.address, 0, network.islands.count, 5, self.tol*.1, 1.0)
        if self.direct is None or len(self.direct.mode) != len(network.i):
            self.direct = new(Direct, fill=20*len(network.v)+100, d=d, n=3*d-3, m=len(network.i), n_b=len(network.v))
        begin_direct(network.address, self.direct.address)
        for k in range(network.islands.count):
            s = al(network.address, self.direct.address, k, self.tol, 40)
            self.methods[s] = self.methods.get(s, 0) + 1
        self.residual = judge(network.address)
        return self.residual
