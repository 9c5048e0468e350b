/* Written by make_bindings.py from api_table.py. Change the table. */
#include <stddef.h>

#include "feltwire.h"

typedef char hand_options_struct_size[offsetof(fw_hand_options, struct_size) == 0 ? 1 : -1];
typedef char hand_options_reserved[offsetof(fw_hand_options, reserved) == 4 ? 1 : -1];
typedef char hand_options_server[offsetof(fw_hand_options, server) == 8 ? 1 : -1];
typedef char hand_options_fingerprint[offsetof(fw_hand_options, fingerprint) == 16 ? 1 : -1];
typedef char hand_options_fingerprint_file[offsetof(fw_hand_options, fingerprint_file) == 24 ? 1 : -1];
typedef char hand_options_ca_file[offsetof(fw_hand_options, ca_file) == 32 ? 1 : -1];
typedef char hand_options_token_file[offsetof(fw_hand_options, token_file) == 40 ? 1 : -1];
typedef char hand_options_scene[offsetof(fw_hand_options, scene) == 48 ? 1 : -1];
typedef char hand_options_name[offsetof(fw_hand_options, name) == 56 ? 1 : -1];
typedef char hand_options_device[offsetof(fw_hand_options, device) == 64 ? 1 : -1];
typedef char hand_options_spec[offsetof(fw_hand_options, spec) == 72 ? 1 : -1];
typedef char hand_options_duration[offsetof(fw_hand_options, duration) == 80 ? 1 : -1];
typedef char hand_options_stale_after[offsetof(fw_hand_options, stale_after) == 88 ? 1 : -1];
typedef char hand_options_more[offsetof(fw_hand_options, more) == 96 ? 1 : -1];
typedef char hand_options_more_count[offsetof(fw_hand_options, more_count) == 104 ? 1 : -1];
typedef char size_of_hand_options[sizeof(fw_hand_options) == 112 ? 1 : -1];
typedef char pose_struct_size[offsetof(fw_pose, struct_size) == 0 ? 1 : -1];
typedef char pose_reserved[offsetof(fw_pose, reserved) == 4 ? 1 : -1];
typedef char pose_position[offsetof(fw_pose, position) == 8 ? 1 : -1];
typedef char pose_orientation[offsetof(fw_pose, orientation) == 32 ? 1 : -1];
typedef char pose_buttons[offsetof(fw_pose, buttons) == 64 ? 1 : -1];
typedef char pose_deadman[offsetof(fw_pose, deadman) == 68 ? 1 : -1];
typedef char size_of_pose[sizeof(fw_pose) == 72 ? 1 : -1];
typedef char session_struct_size[offsetof(fw_session, struct_size) == 0 ? 1 : -1];
typedef char session_reserved[offsetof(fw_session, reserved) == 4 ? 1 : -1];
typedef char session_number[offsetof(fw_session, number) == 8 ? 1 : -1];
typedef char session_servo_period[offsetof(fw_session, servo_period) == 16 ? 1 : -1];
typedef char session_hold_time[offsetof(fw_session, hold_time) == 24 ? 1 : -1];
typedef char session_stiffness[offsetof(fw_session, stiffness) == 32 ? 1 : -1];
typedef char session_start_position[offsetof(fw_session, start_position) == 40 ? 1 : -1];
typedef char session_start_normal[offsetof(fw_session, start_normal) == 64 ? 1 : -1];
typedef char size_of_session[sizeof(fw_session) == 88 ? 1 : -1];
typedef char tick_struct_size[offsetof(fw_tick, struct_size) == 0 ? 1 : -1];
typedef char tick_reserved[offsetof(fw_tick, reserved) == 4 ? 1 : -1];
typedef char tick_number[offsetof(fw_tick, number) == 8 ? 1 : -1];
typedef char tick_time[offsetof(fw_tick, time) == 16 ? 1 : -1];
typedef char tick_position[offsetof(fw_tick, position) == 24 ? 1 : -1];
typedef char tick_orientation[offsetof(fw_tick, orientation) == 48 ? 1 : -1];
typedef char tick_force[offsetof(fw_tick, force) == 80 ? 1 : -1];
typedef char tick_torque[offsetof(fw_tick, torque) == 104 ? 1 : -1];
typedef char tick_reply_age[offsetof(fw_tick, reply_age) == 128 ? 1 : -1];
typedef char tick_balance[offsetof(fw_tick, balance) == 136 ? 1 : -1];
typedef char tick_account_cut[offsetof(fw_tick, account_cut) == 144 ? 1 : -1];
typedef char tick_zero_force_reason[offsetof(fw_tick, zero_force_reason) == 152 ? 1 : -1];
typedef char tick_connected[offsetof(fw_tick, connected) == 156 ? 1 : -1];
typedef char size_of_tick[sizeof(fw_tick) == 160 ? 1 : -1];
