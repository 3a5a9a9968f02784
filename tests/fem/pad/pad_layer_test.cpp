// SPDX-License-Identifier: Apache-2.0

// The layer of a pad: integrals, influence of cells and base stress, against numbers of an independent quadrature with
// twenty digits, against limits in closed form and against the line (fem/layer), a layer in plane strain.
#include "fem/pad/pad_layer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "fem/layer/element_compliance.h"
#include "fem/layer/layer_table.h"
#include "fem/layer/layer_transforms.h"
#include "fem/pad/pad_cells.h"
#include "fem/pad/pad_search.h"
#include "fem/pad/pad_solver.h"

namespace tactel::fem::pad_layer_test {

constexpr double pi = std::numbers::pi;
constexpr double printed = 1e-10;  // the numbers have ten digits behind the point

struct IntegralCase {
  double poisson, rho;
  PadValues expected;
};

IntegralCase integrals(double poisson, double rho, std::array<double, pad_integrals> v) {
  return {poisson, rho, Eigen::Map<const PadValues>(v.data())};
}

// z0, A, B, Z, b0, bA, bB, bxz, bzx
const IntegralCase integral_cases[] = {
    integrals(0.3, 0, {-1.3768541655, -1.2081554399, 0, 0, 4.3615935727, 0.4771309316, 0, 0, 0}),
    integrals(0.3, 1,
              {-0.9416638921, -0.9756658946, -0.0152589560, -0.3378856904, 0.5098587583, 0.5146327282, -0.3662317792,
               0.5137206262, 0.8108925204}),
    integrals(0.45, 0.5,
              {-1.4376406996, -1.0052956555, -0.0080883633, -0.2281282386, 2.3199907058, 0.5125268704, -0.3761131016,
               1.3391698952, 1.4398984781}),
    integrals(0.45, 2,
              {-0.5356253575, -0.6109805510, 0.0454257801, -0.1539634371, 0.0030853225, 0.1375024620, -0.1477974156,
               0.0822047873, 0.1060057350}),
    integrals(0.5, 1,
              {-1.1256978531, -0.8193793370, -0.0081913207, -0.2779067186, 0.4019197479, 0.4908943346, -0.4747173541,
               0.7700150585, 0.7700150585})};

TEST(PadLayer, IntegralsAreThoseOfAnIndependentQuadrature) {
  for (const IntegralCase& c : integral_cases) {
    const PadValues off = PadIntegrals(c.poisson).at(c.rho).value - c.expected;
    EXPECT_LE(off.abs().maxCoeff(), printed) << c.poisson << " " << c.rho << ": " << off.transpose();
  }
}

TEST(PadLayer, SlopesAreThoseOfTheIntegrals) {
  const PadIntegrals layer(0.45);
  for (const double rho : {0.01, 0.4, 3.0}) {
    const double step = 1e-4;
    const PadValues slope = (layer.at(rho + step).value - layer.at(rho - step).value) / (2 * step);
    EXPECT_LE((layer.at(rho).slope - slope).abs().maxCoeff(), 1e-6) << rho;  // step^2 times third derivatives of 40
  }
}

TEST(PadLayer, TablesAreThoseOfDirectQuadrature) {
  for (const double poisson : {0.0, 0.45, 0.5}) {
    const PadLayer layer(poisson);
    const PadIntegrals direct(poisson);
    double worst = 0, worst_stress = 0;
    for (double rho = 0.0031; rho < PadLayer::range; rho += rho < 1 ? 0.005 : 0.1) {
      const PadValues value = direct.at(rho).value;
      worst = std::max(worst, (layer.displacements(rho) - value.head<4>()).abs().maxCoeff());
      worst_stress = std::max(worst_stress, (layer.stresses(rho) - value.tail<5>()).abs().maxCoeff());
    }
    EXPECT_LE(worst, PadLayer::largest_error) << poisson;
    EXPECT_LE(worst_stress, 1e-7) << poisson;  // of 4.5: their fourth derivatives are larger
  }
}

TEST(PadLayer, BeyondTheTablesTheLayerDoesNotMove) {
  const PadLayer layer(0.5);  // where it moves farthest
  const Eigen::Array4d inside = layer.displacements(PadLayer::range - 1e-9),
                       beyond = layer.displacements(PadLayer::range);
  EXPECT_LE((inside - beyond).abs().maxCoeff(), 1e-6);  // exp(-0.739 * 24) = 2e-8, times a
}

TEST(PadLayer, InfluenceOfCells) {
  struct Case {
    double poisson, hx, hy;
    int i, j;
    CellInfluence expected;
  };
  const Case cases[] = {
      {0.3, .25, .25, 0, 0, {0.2304916581, 0.2944279541, 0.2944279541, 0, 0, 0}},
      {0.3, .25, .25, 3, 2, {0.0020565184, 0.0131533553, 0.0097206431, 0.0041173284, 0.0012087739, 0.0008053773}},
      {0.45, .25, .25, 0, 0, {0.1980865982, 0.2997860429, 0.2997860429, 0, 0, 0}},
      {0.45, .25, .25, 1, 0, {0.0410182558, 0.0993615760, 0.0558756386, 0, 0.0038370285, 0}},
      {0.45, .25, .25, 1, 1, {0.0218826982, 0.0498561959, 0.0498561959, 0.0174014394, 0.0011304945, 0.0011304945}},
      {0.45, .25, .5, 1, 1, {0.0154273337, 0.0429002454, 0.0676656027, 0.0195109482, -0.0005325509, -0.0014209504}},
      {0.5, .25, .25, 0, 0, {0.1841473131, 0.3001546334, 0.3001546334, 0, 0, 0}},
      {0.5, 1, 1, 1, 0, {-0.0159149619, 0.2786420906, 0.0782539084, 0, -0.0586467446, 0}}};
  for (const Case& c : cases) {
    const double near_to = printed + 0.3 * PadLayer::largest_error * c.hx * c.hy;
    static std::map<double, PadLayer> layers;
    const CellInfluence now =
        layers.try_emplace(c.poisson, c.poisson).first->second.influence(1, c.hx, c.hy, c.i * c.hx, c.j * c.hy);
    const auto near = [&](double value, double expected) {
      EXPECT_NEAR(value, expected, near_to) << c.poisson << c.i << c.j;
    };
    near(now.zz, c.expected.zz), near(now.xx, c.expected.xx), near(now.yy, c.expected.yy);
    near(now.xy, c.expected.xy), near(now.xz, c.expected.xz), near(now.yz, c.expected.yz);
  }
}

TEST(PadLayer, BaseStressOfACell) {
  PadBaseStress expected;
  expected << -.0054819550, -.0027405769, .0027155951, .0067593470, .0031623850, -.0048350463, .0031623850, .0020153755,
      -.0024171419;
  const PadBaseStress now = PadLayer(0.45).base_stress(1, 0.25, 0.25, 1, 0.5);
  EXPECT_LE((now - expected).cwiseAbs().maxCoeff(), 1e-9) << now;  // 1e-7 of the tables times the cell over 2 pi
}

// Summed from parts that neighbours share, a wide cell has the stress of its own quadrature.
TEST(PadLayer, WideCellsShareTheirParts) {
  const PadLayer layer(0.5);
  const double H = 2, hx = 6.3 * H, hy = 2.2 * H, x = 4.1, y = -3.3;
  const int n = 4;
  const std::vector<PadBaseStress> all = layer.base_stresses(H, hx, hy, n, x, y);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      EXPECT_LT((all[i * n + j] - layer.base_stress(H, hx, hy, x - i * hx, y - j * hy)).norm(), 1e-12) << i << j;
  // Beyond the reach of the layer, and so far away that no part could be counted.
  for (const double far : {300.0, 1e15})
    for (const PadBaseStress& none : layer.base_stresses(H, hx, hy, n, far, y)) EXPECT_EQ(none.norm(), 0) << far;
}

TEST(PadLayer, UnderUniformTractionItIsTheOedometerAndSimpleShear) {
  for (const double nu : {0.3, 0.45, 0.5}) {
    const PadLayer layer(nu);
    const double H = 2, h = 0.5 * H;
    CellInfluence sum;
    PadBaseStress stress = PadBaseStress::Zero();
    for (int i = -48; i <= 48; ++i)
      for (int j = -48; j <= 48; ++j) {
        const CellInfluence c = layer.influence(H, h, h, i * h, j * h);
        sum.zz += c.zz, sum.xx += c.xx, sum.yy += c.yy, sum.xy += c.xy, sum.xz += c.xz, sum.yz += c.yz;
        stress += layer.base_stress(H, h, h, i * h, j * h);
      }
    const double oedometer = (1 + nu) * (1 - 2 * nu) / (1 - nu) * H, shear = 2 * (1 + nu) * H;
    EXPECT_NEAR(sum.zz, oedometer, 2e-6 * H) << nu;  // 24 H at nu = 1/2 cut off 1e-6
    EXPECT_NEAR(sum.xx, shear, 2e-6 * H);
    EXPECT_NEAR(sum.yy, shear, 2e-6 * H);
    EXPECT_NEAR(sum.xy, 0, 1e-12);
    EXPECT_NEAR(sum.xz, 0, 1e-12);
    PadBaseStress uniform;
    uniform << 0, 0, 1, 1, 0, 0, 0, 1, 0;
    EXPECT_LE((stress - uniform).cwiseAbs().maxCoeff(), 2e-6) << stress;
  }
}

/// int T cos(a x) da / pi of the antiplane stress 1 / cosh a, in closed form; H = 1.
double antiplane_base(double x) { return 1 / (2 * std::cosh(pi * x / 2)); }

TEST(PadLayer, ARowOfCellsIsTheLine) {
  const double H = 1.5, h = 0.1, nu = 0.45;
  const PadLayer layer(nu);
  const LayerTable line(nu);
  const ElementCompliance elements = element_compliance(line, H, h, 12);
  for (const int k : {0, 1, 3, 10}) {
    CellInfluence sum;
    PadBaseStress stress = PadBaseStress::Zero();
    for (int j = -360; j <= 360; ++j) {
      const CellInfluence c = layer.influence(H, h, h, k * h, j * h);
      sum.zz += c.zz, sum.xx += c.xx, sum.xz += c.xz;
      stress += layer.base_stress(H, h, h, k * h, j * h);
    }
    EXPECT_NEAR(sum.zz / h, elements.yy[k], 2e-6) << k;  // the line's tables, and 24 H
    EXPECT_NEAR(sum.xx / h, elements.xx[k], 2e-6) << k;
    EXPECT_NEAR(sum.xz / h, elements.xy[k], 2e-6) << k;
    if (k == 0) {
      EXPECT_NEAR(sum.zz / h, 1.825497, 1e-6);
    }
    if (k == 1) {
      EXPECT_NEAR(sum.xz / h, 0.051284, 1e-6);
    }
    // The means over an element of the line's base stress; u_y of the line is u_z here.
    const BaseStress right = line.base_integral((k + 0.5) * h / H), left = line.base_integral((k - 0.5) * h / H);
    EXPECT_NEAR(stress(0, 2), right.sigma_by_y - left.sigma_by_y, 1e-6) << k;
    EXPECT_NEAR(stress(0, 0), right.sigma_by_x - left.sigma_by_x, 1e-6) << k;
    EXPECT_NEAR(stress(1, 2), right.tau_by_y - left.tau_by_y, 1e-6) << k;
    EXPECT_NEAR(stress(1, 0), right.tau_by_x - left.tau_by_x, 1e-6) << k;
    EXPECT_NEAR(stress(2, 1), h / H * antiplane_base(k * h / H), 3e-4 * h / H) << k;  // at the middle, not the mean
  }
}

TEST(PadLayer, AThickLayerIsTheHalfSpace) {
  const double nu = 0.3, H = 1e6;
  const PadLayer layer(nu);
  // Boussinesq and Cerruti at (3, 4) from a small cell; both fall like 1 / r.
  const double h = 0.01, r = 5, force = h * h;
  const CellInfluence c = layer.influence(H, h, h, 300 * h, 400 * h);
  const double near = 1e-4 * force / r;  // the cell's extension (h / r)^2, and 1 / H
  EXPECT_NEAR(c.zz, (1 - nu * nu) / (pi * r) * force, near);
  EXPECT_NEAR(c.xx, (1 + nu) / (pi * r) * (1 - nu + nu * 0.36) * force, near);
  EXPECT_NEAR(c.yy, (1 + nu) / (pi * r) * (1 - nu + nu * 0.64) * force, near);
  EXPECT_NEAR(c.xy, (1 + nu) / (pi * r) * nu * 0.48 * force, near);
  EXPECT_NEAR(c.xz, (1 + nu) * (1 - 2 * nu) / (2 * pi * r) * 0.6 * force, near);
  EXPECT_NEAR(c.yz, (1 + nu) * (1 - 2 * nu) / (2 * pi * r) * 0.8 * force, near);
}

TEST(PadLayer, InfluenceIsSymmetricAndPositiveDefinite) {
  const int n = 6;
  const double h = 0.2;
  const PadInfluence c(PadLayer(0.5), 1, h, 1.5 * h, n);
  Eigen::MatrixXd C(3 * n * n, 3 * n * n);  // u_z, u_x, u_y by f_z, f_x, f_y
  for (int i = 0; i < n * n; ++i)
    for (int j = 0; j < n * n; ++j) {
      const Eigen::Index k = c.at(j / n - i / n, j % n - i % n);
      C.block<3, 3>(3 * i, 3 * j) << c.zz[k], -c.xz[k], -c.yz[k], c.xz[k], c.xx[k], c.xy[k], c.yz[k], c.xy[k], c.yy[k];
    }
  EXPECT_LE((C - C.transpose()).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(C).eigenvalues().minCoeff(), 0);
}

TEST(PadLayer, AtNuOneHalfBaseShearAndNormalAreReciprocal) {
  const PadIntegrals layer(0.5);
  for (const double rho : {0.1, 1.0, 5.0}) {
    const PadValues v = layer.at(rho).value;
    EXPECT_NEAR(v[pad_bxz], v[pad_bzx], 1e-13);
  }
}

TEST(PadLayer, ATractionIsTransmittedToTheBase) {
  // The quadrature over a cell is fine enough: the stress at many places under one cell sums to its force.
  const PadLayer layer(0.45);
  const double step = 0.2;
  PadBaseStress sum = PadBaseStress::Zero();
  for (int i = -100; i <= 100; ++i)
    for (int j = -100; j <= 100; ++j) sum += step * step * layer.base_stress(1, 0.4, 0.3, i * step, j * step);
  EXPECT_NEAR(sum(0, 2), 0.12, 1e-6);
  EXPECT_NEAR(sum(1, 0), 0.12, 1e-6);
}

TEST(PadLayer, NormalInfluenceOfTheSearchHoldsForCellsOfAnySide) {
  for (const double poisson : {0.3, 0.5}) {
    const PadLayer layer(poisson);
    for (const auto& [hx, hy] : {std::pair{0.1, 0.2}, {0.35, 0.35}, {0.4, 0.2}, {1.0, 0.4}, {2.0, 3.0}}) {
      const Eigen::MatrixXd zz = layer.normal_influence(2, 2 * hx, 2 * hy, 5);
      for (int i = 0; i < 5; ++i)
        for (int j = 0; j < 5; ++j) {
          const double exact = layer.influence(2, 2 * hx, 2 * hy, 2 * i * hx, 2 * j * hy).zz;
          EXPECT_NEAR(zz(i, j), exact, 3e-3 * zz(0, 0)) << poisson << " " << hx << " " << hy << " " << i << " " << j;
        }
    }
  }
}

// The traction of a wide cell keeps its force and has no second moment, so that cubic pressures at the middles of cells
// are reproduced; means over parts of width 1 / m add 1 / (12 m^2).
TEST(PadLayer, SharesOfACellReproduceCubicPressures) {
  EXPECT_EQ(PadLayer::shares(PadLayer::narrow_cell).size(), 1u);
  for (const double side : {0.9, 1.1, 2.5, 40.0}) {
    const std::vector<PadLayer::Share> shares = PadLayer::shares(side);
    const double parts = static_cast<double>(shares.size()) / 5;
    EXPECT_LT(side / parts, 0.5);
    double sum = 0, second = 0;
    for (const auto& [place, share] : shares)
      sum += share, second += share * (place * place - 1 / (12 * parts * parts));
    EXPECT_NEAR(sum, 1, 1e-14) << side;
    if (side < 1)
      EXPECT_GT(second, 0) << side;  // 1 / 12 where the traction is uniform
    else
      EXPECT_NEAR(second, 0, 1e-13) << side;
  }
}

// Thin incompressible rubber gives way only where the pressure bends: with uniform tractions P was 32 % low at 12 cells
// of 2 H, and half at 3 H.
TEST(PadLayer, WideCellsBearThinIncompressibleRubber) {
  PadScene scene;
  scene.sensor = {.tactels = {1, 1}, .thickness = 1, .young = 1, .poisson = 0.5};
  scene.friction = 0.6;
  scene.load.indentation = {0.1};
  const PadLayer layer(0.5);
  for (const double radius : {150.0, 600.0}) {
    scene.indenter.shape = Sphere{radius};
    const PadLayout laid = lay_cells(scene, layer, 12, false);
    EXPECT_GT(laid.cells.hx, 1);
    PadCells fine = laid.cells;
    fine.n = 60, fine.hx /= 5, fine.hy /= 5;
    const PadStep truth = PadSolver(layer, {.cells = 60, .pressing_increments = 4}).solve_on(fine, scene).steps[0];
    const PadStep step = PadSolver(layer, {}).solve_on(laid.cells, scene).steps[0];
    EXPECT_NEAR(step.P / truth.P, 1, 0.05) << radius;  // the edge falls between cells: 3 % of the radius is 6 P's
    EXPECT_NEAR(step.stress(0, 0) / truth.stress(0, 0), 1, 0.05) << radius;
  }
}

}  // namespace tactel::fem::pad_layer_test
