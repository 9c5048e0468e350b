/* Your own device as a plugin: a shared library in C, which the installed program loads.
 *
 *   cc -std=c99 -shared -fPIC -I/usr/local/include my_plugin.c -o my_plugin.so
 *   feltwire-client --connect localhost:6720 --scene room --device plugin:./my_plugin.so:0.2
 *
 * The device in this example is a simulated handle on a spring. For a real device, replace the lines that move the handle by
 * calls to the library of the device's manufacturer. The argument after the last colon (0.2) is the mass of the handle [kg]. */

#include <feltwire/client/drivers/plugin/feltwire_device_v1.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
  double mass;                                /* [kg] */
  double position[3], velocity[3], force[3];  /* [m], [m/s], [N] on the hand */
  volatile sig_atomic_t released;             /* any thread may set it */
} Handle;

static const double kDamping = 2.0, kSpring = 100.0, kTick = 1e-3; /* [N s/m], [N/m], [s] */

static void* open_handle(const char* arguments, feltwire_spec_v1* spec, char* error, size_t error_size) {
  const double mass = *arguments != '\0' ? strtod(arguments, NULL) : 0.2;
  Handle* handle;
  if (!(mass > 0.01 && mass < 10.0)) {
    snprintf(error, error_size, "'%s' is no mass of a handle; give 0.01 to 10 [kg]", arguments);
    return NULL;
  }
  handle = calloc(1, sizeof *handle);
  if (handle == NULL) {
    snprintf(error, error_size, "no memory");
    return NULL;
  }
  handle->mass = mass;
  handle->position[2] = 0.01;
  strcpy(spec->name, "my_plugin");
  spec->source = "computed"; /* for a real device: how you measured these values; null if you assume them */
  spec->translation_dof = 3;
  spec->damping[0] = spec->damping[1] = spec->damping[2] = kDamping;
  spec->apparent_mass = mass;
  spec->least_mass = 0.9 * mass;
  spec->max_force = 6.0;
  spec->continuous_force = 2.0;
  spec->workspace[0] = spec->workspace[1] = spec->workspace[2] = 0.2;
  return handle;
}

/* longest_tick is 0, so the client's timer sets the servo rate, and the device needs no wait(). */
static int read_handle(void* device, feltwire_reading_v1* reading) {
  Handle* h = device;
  int i;
  for (i = 0; i < 3; ++i) {
    const double rest = i == 2 ? -0.01 : 0.0; /* [m] a simulated finger pulls the handle to 1 cm below z = 0 */
    const double pull = kSpring * (rest - h->position[i]) - kDamping * h->velocity[i];
    h->velocity[i] += kTick / h->mass * (pull + h->force[i]);
    h->position[i] += kTick * h->velocity[i];
    reading->position[i] = h->position[i];
  }
  return FELTWIRE_OK;
}

static int write_handle(void* device, const double force[3], const double torque[3], double held_force[3],
                        double held_torque[3]) {
  Handle* h = device;
  (void)torque; /* the specification has no torque */
  (void)held_force;
  (void)held_torque; /* the device holds the whole force */
  if (h->released) {
    memset(h->force, 0, sizeof h->force);
    return 1;
  }
  memcpy(h->force, force, sizeof h->force);
  return 0;
}

static void release_handle(void* device) { ((Handle*)device)->released = 1; }

static void close_handle(void* device) { free(device); }

const feltwire_device_v1* feltwire_device(void) {
  static const feltwire_device_v1 functions = {
      FELTWIRE_DEVICE_VERSION, sizeof functions, open_handle, NULL, read_handle, write_handle, release_handle, close_handle,
      NULL /* actuation_lag: unknown; feltwire-client identify measures it */,
      NULL /* transmission: unknown */};
  return &functions;
}
