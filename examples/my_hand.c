/* A hand in C. The program is the device: it moves the hand 4 mm into a surface and out again, and
 * prints the force that the hand feels.
 *
 *   feltwire-server --scene scenes/room.json
 *   export FELTWIRE_FINGERPRINT_FILE=~/.local/state/feltwire/fingerprint
 *   export FELTWIRE_TOKEN_FILE=~/.local/state/feltwire/local.token
 *   my_hand localhost:6720 room
 *
 * cc -std=c99 my_hand.c -lfeltwire -lm */
#define _POSIX_C_SOURCE 199309L /* nanosleep() */
#include <feltwire.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static int failed(const char* what) {
  fprintf(stderr, "my_hand: %s: %s\n", what, fw_last_error());
  return 1;
}

int main(int argc, char** argv) {
  if (argc != 3) return fprintf(stderr, "usage: my_hand HOST:PORT SCENE\n"), 2;
  fw_hand_options options;
  fw_hand_options_default(&options, sizeof options);
  options.server = argv[1];
  options.scene = argv[2];
  options.fingerprint_file = getenv("FELTWIRE_FINGERPRINT_FILE");
  options.token_file = getenv("FELTWIRE_TOKEN_FILE");
  options.device = "caller";
  options.name = "my_hand";
  fw_hand* hand = NULL;
  if (fw_hand_open(&options, &hand) != FW_OK) return failed("cannot join");

  fw_session session;
  fw_hand_session(hand, &session, sizeof session);
  fw_pose pose;
  fw_pose_default(&pose, sizeof pose);
  fw_tick tick;
  const int steps = 4000;
  for (int i = 0, result = FW_OK; result != FW_ENDED; ++i) {
    /* From 4 mm above the surface to 4 mm below it, and back. */
    const double height = 0.004 * cos(2.0 * 3.14159265358979 * i / steps); /* [m] */
    for (int axis = 0; axis < 3; ++axis)
      pose.position[axis] = session.start_position[axis] + height * session.start_normal[axis];
    result = fw_hand_exchange(hand, &pose, &tick, sizeof tick);
    if (result < 0) break;
    /* A real device applies tick.force [N] now, until the next exchange. */
    if (i % 200 == 0)
      printf("%4.2f s  height %6.3f mm  force %5.2f N  %s\n", tick.time, 1e3 * height,
             sqrt(tick.force[0] * tick.force[0] + tick.force[1] * tick.force[1] +
                  tick.force[2] * tick.force[2]),
             fw_zero_force_text(tick.zero_force_reason));
    if (i == steps) fw_hand_stop(hand); /* the force fades; then the result is FW_ENDED */
    const struct timespec pause = {0, 1000000}; /* 1 ms: a real device sets this pace itself */
    nanosleep(&pause, NULL);
  }
  /* A real device gets a force of zero here, and has a watchdog of its own. */
  return fw_hand_close(hand) == FW_OK ? 0 : failed("the run ended early");
}
