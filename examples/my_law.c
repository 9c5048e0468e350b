/* A bounding law of your own as a shared library in C, which the installed laboratory judges.
 *
 *   cc -std=c99 -shared -fPIC -I/usr/local/include my_law.c -o my_law.so -lm
 *   feltwire-lab extremes --law ./my_law.so      exit status 1 if it breaks its promise
 *   feltwire-lab compare --law ./my_law.so       beside the built-in methods
 *
 * The law is that of my_bound.cpp: it stores the work of the hand on the device and the energy that the device's damping
 * dissipates, and passes a force as far as the store covers what the hand can take back with it. Compiled with -DSIGN=-1 it has a
 * wrong sign, which the laboratory finds. */

#include <feltwire/sim/own_laws/feltwire_law_v1.h>
#include <math.h>
#include <string.h>

#ifndef SIGN
#define SIGN 1.0 /* factor of the hand's work -f.dx; -1 is wrong */
#endif

typedef struct {
  double damping, period, energy, held[3]; /* [N s/m], [s], [J], [N]; for the torque [N m s/rad], [N m] */
} Port;

typedef struct {
  Port force, torque;
} State;

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static double share(Port* port, const double wanted[3], const double moved[3], double time) {
  const double reserve = 1e-290; /* [J] tiny doubles lose digits */
  double allowed, size = sqrt(dot(wanted, wanted));
  port->energy += port->damping / time * dot(moved, moved) - SIGN * dot(port->held, moved);
  allowed = sqrt(4.0 * port->damping / port->period * fmax(0.0, port->energy - reserve));
  return size > allowed ? allowed / size : 1.0;
}

static void hold(Port* port, const double force[3]) {
  memcpy(port->held, force, sizeof port->held);
  if (port->damping > 0.0) port->energy = fmin(port->energy, dot(force, force) * port->period / (4.0 * port->damping));
}

static int32_t reset(void* memory, const feltwire_law_device_v1* device) {
  State* s = memory;
  s->force.damping = device->least_damping;
  s->torque.damping = device->least_rotational_damping;
  s->force.period = s->torque.period = device->period;
  return 0;
}

static void set_held(void* memory, const feltwire_law_force_v1* held) {
  State* s = memory;
  double force[3];
  int i;
  for (i = 0; i < 3; ++i) force[i] = held->elastic[i] + held->frictional[i];
  hold(&s->force, force);
  hold(&s->torque, held->torque);
}

static void step(void* memory, const feltwire_law_step_v1* now, feltwire_law_force_v1* rendered) {
  State* s = memory;
  double wanted[3], f, t;
  int i;
  for (i = 0; i < 3; ++i) wanted[i] = now->command.elastic[i] + now->command.frictional[i];
  f = share(&s->force, wanted, now->displacement, now->hold_time);
  t = share(&s->torque, now->command.torque, now->rotation, now->hold_time);
  for (i = 0; i < 3; ++i) {
    rendered->elastic[i] = f * now->command.elastic[i];
    rendered->frictional[i] = f * now->command.frictional[i];
    rendered->torque[i] = t * now->command.torque[i];
  }
  set_held(memory, rendered);
}

const feltwire_law_v1* feltwire_law(void) {
  static const feltwire_law_v1 law = {
      FELTWIRE_LAW_VERSION, sizeof law, "my_law", "one store of energy for all directions", FELTWIRE_PROMISE_PORT,
      FELTWIRE_KEPT_ALL,    1,          sizeof(State), reset, step, set_held};
  return &law;
}
