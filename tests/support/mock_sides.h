#pragma once

#include <functional>

#include "protocol/contract/error.h"
#include "protocol/contract/subsystem.h"

namespace tandem::test {

/// A free rigid body whose port is its centre, moving along x by semi-implicit Euler:
///   v⁺ = v + H f/m,  x⁺ = x + H v⁺.   Jacobian: ∂v⁺/∂f = H/m, ∂x⁺/∂f = H²/m.
class MassMbs : public MbsSide {
 public:
  struct State {
    double x = 0.0, v = 0.0;
  };
  MassMbs(double mass_kg, State start, bool can_linearize = true)
      : mass_kg_(mass_kg), state_(start), saved_(start) {
    info_ = {.name = "mbs", .ports = {{"p", 0.0}}, .can_linearize = can_linearize};
  }
  const SubsystemInfo& info() const override { return info_; }
  MotionSet initialize(const WrenchSet&) override { return motion(); }
  StepResult<MotionSet> advance(const StepRequest<WrenchSet>& request) override {
    ++advances;
    StepResult<MotionSet> result;
    const double h_s = to_seconds(request.step);
    state_.v += h_s * request.input.end[0].f_P_W.x() / mass_kg_;
    state_.x += h_s * state_.v;
    result.outcome = Outcome::Done;
    result.message.clear();
    result.output = motion();
    if (request.linearize && info_.can_linearize) {
      result.jacobian = InterfaceJacobian::Zero(12, 6);
      (*result.jacobian)(0, 0) = h_s * h_s / mass_kg_;
      (*result.jacobian)(6, 0) = h_s / mass_kg_;
    }
    return result;
  }
  void checkpoint() override { saved_ = state_; }
  void rollback() override { state_ = saved_; }
  Observation observe() override {
    return {.energy = {.kinetic_J = 0.5 * mass_kg_ * state_.v * state_.v}};
  }

  int advances = 0;

 private:
  MotionSet motion() const {
    MotionSet motions(1);
    motions[0].p_WP.x() = state_.x;
    motions[0].v_WP.x() = state_.v;
    return motions;
  }
  SubsystemInfo info_;
  double mass_kg_;
  State state_, saved_;
};

/// A mass that follows the port rigidly and hangs on a spring to ground, by backward Euler:
///   λ = −m (v⁺ − v)/H − k x⁺ (1 + ε x⁺²).   ε = 0: affine in the port motion.
class MassSpringFem : public FemSide {
 public:
  MassSpringFem(double mass_kg, double stiffness_N_per_m, double hardening_per_m2 = 0.0)
      : mass_kg_(mass_kg), k_(stiffness_N_per_m), hardening_(hardening_per_m2) {
    info_ = {.name = "fem", .ports = {{"p", 0.1}}, .can_linearize = true};
  }
  const SubsystemInfo& info() const override { return info_; }
  WrenchSet initialize(const MotionSet& m) override {
    x_ = m[0].p_WP.x();
    v_ = m[0].v_WP.x();
    return wrench(spring_N(x_));
  }
  StepResult<WrenchSet> advance(const StepRequest<MotionSet>& request) override {
    ++advances;
    StepResult<WrenchSet> result;
    if (fail_at_advance == advances) {
      result.message = "fails on purpose. Do not ask it to.";
      return result;
    }
    const Motion& end = request.input.end[0];
    const double h_s = to_seconds(request.step);
    const double x_new = end.p_WP.x();
    result.output = wrench(-mass_kg_ * (end.v_WP.x() - v_) / h_s + spring_N(x_new));
    x_ = x_new;
    v_ = end.v_WP.x();
    result.outcome = Outcome::Done;
    result.message.clear();
    if (request.linearize) {
      result.jacobian = InterfaceJacobian::Zero(6, 12);
      (*result.jacobian)(0, 0) = -k_ * (1.0 + 3.0 * hardening_ * x_ * x_);
      (*result.jacobian)(0, 6) = -mass_kg_ / h_s;
    }
    return result;
  }
  void checkpoint() override { saved_x_ = x_, saved_v_ = v_; }
  void rollback() override { x_ = saved_x_, v_ = saved_v_; }
  Observation observe() override {
    return {.energy = {.kinetic_J = 0.5 * mass_kg_ * v_ * v_, .elastic_J = 0.5 * k_ * x_ * x_}};
  }

  int advances = 0;
  int fail_at_advance = -1;

 private:
  double spring_N(double x) const { return -k_ * x * (1.0 + hardening_ * x * x); }
  static WrenchSet wrench(double f) {
    WrenchSet wrenches(1);
    wrenches[0].f_P_W.x() = f;
    return wrenches;
  }
  SubsystemInfo info_;
  double mass_kg_, k_, hardening_;
  double x_ = 0.0, v_ = 0.0, saved_x_ = 0.0, saved_v_ = 0.0;
};

}  // namespace tandem::test
