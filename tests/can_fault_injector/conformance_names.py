"""The test names of ISO 16845-1:2016, clauses 7.1 to 7.6, 8.1 to 8.6 and 9.6, and the tests here that stand for them.

Only names and numbers come from the standard; cases and expectations were written from the rules of ISO 11898-1. The
cases use classic frames, and CAN FD frames where the rule is about CAN FD; the standard repeats most clauses with both.
Each test carries its names: ``pytest -k iso_7_6_11`` runs what stands for that one.
"""

FC, FLAGS, ARBITRATION = "test_fault_confinement", "test_flags_and_spaces", "test_arbitration_and_stuffing"
TIMING = "test_bit_timing"
SENDERS, STATES, SPACES = "test_delimiters_of_senders", "test_fault_states", "test_spaces_between_frames"

# clause: the function for test 1, 2, …
TESTS = {
    "7.1": [
        f"{SENDERS}:test_every_identifier_bit_and_length_is_sent_and_received",
        f"{SENDERS}:test_every_identifier_bit_and_length_is_sent_and_received",
        f"{ARBITRATION}:test_ar01_loss_at_every_bit_of_the_standard_identifier",
        f"{ARBITRATION}:test_fm01_non_nominal_reserved_bits_of_extended_frames",
        f"{ARBITRATION}:test_fm01_non_nominal_reserved_bits_of_extended_frames",
        f"{ARBITRATION}:test_fd09_recessive_res_bit",
        f"{SENDERS}:test_fd09_frame_after_a_protocol_exception_needs_enough_idle",
        f"{ARBITRATION}:test_fm01_length_codes_above_eight",
        f"{SPACES}:test_id01_frames_without_idle_between_them",
        f"{ARBITRATION}:test_st02_stuff_bits_count_towards_the_next_run",
        f"{ARBITRATION}:test_st01_stuff_bit_after_the_last_crc_bit",
        f"{FLAGS}:test_eo01_dominant_in_eof_7_gives_an_overload_frame_and_the_frame_is_accepted",
    ],
    "7.2": [
        f"{FC}:test_fc01a_acknowledge_bit_read_back_recessive_is_a_bit_error",
        *[f"{ARBITRATION}:test_st01_sixth_equal_bit_in_every_stuffed_field"] * 3,
        f"{FLAGS}:test_ef01_flag_begins_at_the_next_bit_and_after_the_ack_delimiter_for_a_crc_error",
        f"{FLAGS}:test_ef02_crc_and_form_error_give_one_flag",
        f"{FC}:test_fc01_receiver_counts_one_for_an_error",
        f"{ARBITRATION}:test_fd04_wrong_fixed_stuff_bit_is_a_form_error",
        f"{FC}:test_fc01_receiver_counts_one_for_an_error",
        *[f"{FLAGS}:test_eo01_dominant_in_eof_1_to_6_is_a_form_error_of_the_receiver"] * 2,
    ],
    "7.3": [
        f"{FC}:test_fc06_and_fc06a_dominant_bits_after_the_active_flag_of_a_receiver",
        f"{SENDERS}:test_im01_receiver_takes_a_frame_from_the_third_intermission_bit_after_an_error",
        f"{FC}:test_fc05_bit_error_in_the_active_error_flag_of_a_receiver",
        f"{FC}:test_fc01b_dominant_inside_the_error_delimiter",
    ],
    "7.4": [
        f"{SPACES}:test_ov01_overload_frame_on_dominant_in_the_intermission",
        f"{FLAGS}:test_eo01_dominant_in_eof_7_gives_an_overload_frame_and_the_frame_is_accepted",
        f"{SPACES}:test_ov02_dominant_in_the_last_delimiter_bit_gives_an_overload_frame",
        f"{FC}:test_fc05_bit_error_in_the_overload_flag_of_a_receiver",
        f"{FC}:test_fc01b_dominant_inside_the_overload_delimiter",
        f"{FC}:test_fc06_and_fc06a_dominant_bits_after_the_overload_flag",
        f"{SPACES}:test_ov01_overload_frame_on_dominant_in_the_intermission",
    ],
    "7.5": [
        f"{FLAGS}:test_ef06_passive_receiver_counts_equal_bits_of_running_traffic",
        f"{SENDERS}:test_im01_receiver_takes_a_frame_from_the_third_intermission_bit_after_an_error",
        f"{FC}:test_fc06a_dominant_bits_after_the_passive_flag_of_a_receiver",
        f"{STATES}:test_fc11_a_detected_error_never_makes_a_node_active",
        f"{FLAGS}:test_ef04_five_dominant_bits_inside_the_passive_flag",
        f"{SENDERS}:test_fc01b_passive_receiver_finds_its_error_delimiter_corrupted",
        f"{STATES}:test_fc09_error_that_makes_a_receiver_passive_still_sends_an_active_flag",
    ],
    "7.6": [
        f"{FC}:test_fc05_bit_error_in_the_active_error_flag_of_a_receiver",
        f"{FC}:test_fc05_bit_error_in_the_overload_flag_of_a_receiver",
        f"{FC}:test_fc06_and_fc06a_dominant_bits_after_the_active_flag_of_a_receiver",
        f"{FC}:test_fc06_and_fc06a_dominant_bits_after_the_overload_flag",
        f"{FC}:test_fc01a_acknowledge_bit_read_back_recessive_is_a_bit_error",
        *[f"{FC}:test_fc01_receiver_counts_one_for_an_error"] * 5,
        f"{FC}:test_fc02_dominant_after_the_error_flag_of_a_receiver",
        f"{FC}:test_fc01b_dominant_inside_the_error_delimiter",
        f"{FC}:test_fc01b_dominant_inside_the_overload_delimiter",
        *[f"{STATES}:test_fc08_successful_reception"] * 2,
        f"{STATES}:test_fc13_receiver_counts_nothing",
        f"{STATES}:test_fc13_receiver_counts_nothing",
        f"{FC}:test_fc06_and_fc06a_dominant_bits_after_the_active_flag_of_a_receiver",
        f"{STATES}:test_fc13_receiver_counts_nothing",
        f"{STATES}:test_fc13_dominant_last_bit_of_the_error_delimiter",
        f"{STATES}:test_fc13_receiver_counts_nothing",
        f"{FC}:test_fc01_receiver_counts_one_for_an_error",
        f"{STATES}:test_fc13_protocol_exception",
    ],
    "8.1": [
        *[f"{SENDERS}:test_every_identifier_bit_and_length_is_sent_and_received"] * 2,
        f"{ARBITRATION}:test_ar01_loss_at_every_bit_of_the_standard_identifier",
        f"{ARBITRATION}:test_ar01_loss_at_every_bit_of_the_extended_identifier",
        f"{FLAGS}:test_eo02_dominant_in_the_first_intermission_bit_repeats_nothing",
        *[f"{ARBITRATION}:test_st02_sender_puts_stuff_bits_after_five_equal_bits"] * 2,
        f"{SPACES}:test_im01_node_with_a_waiting_frame_after_its_own",
    ],
    "8.2": [
        f"{SPACES}:test_be01_every_other_mismatch_of_a_sender_is_an_error",
        f"{SENDERS}:test_be01_mismatch_in_an_extended_frame",
        f"{FC}:test_fc03x2_stuff_error_in_arbitration",
        f"{FC}:test_fc03x2_stuff_error_in_arbitration",
        f"{FLAGS}:test_eo02_dominant_in_eof_makes_the_sender_repeat",
        f"{FC}:test_fc03_missing_acknowledgement",
        f"{ARBITRATION}:test_fd10_sender_accepts_a_late_acknowledgement",
        f"{FC}:test_fc03x2_does_not_hold_after_rtr",
    ],
    "8.3": [
        f"{FC}:test_fc06_and_fc06a_dominant_bits_after_the_active_flag_of_a_sender",
        f"{SENDERS}:test_im01_sender_starts_from_the_third_intermission_bit_after_an_error",
        f"{FC}:test_fc04_bit_error_in_the_active_error_flag_of_a_sender",
        f"{SENDERS}:test_fc03_sender_finds_its_error_delimiter_corrupted",
    ],
    "8.4": [
        f"{SPACES}:test_ov01_sender_starts_the_next_frame_after_the_overload_frame",
        f"{STATES}:test_fc13_sender_counts_nothing_at_the_last_bit_of_a_delimiter",
        f"{SPACES}:test_im01_node_with_a_waiting_frame_after_its_own",
        f"{FC}:test_fc04_bit_error_in_the_overload_flag_of_a_sender",
        f"{SENDERS}:test_fc03_sender_finds_its_overload_delimiter_corrupted",
    ],
    "8.5": [
        f"{FLAGS}:test_ef05_dominant_in_the_passive_flag_is_no_bit_error",
        f"{SENDERS}:test_im02_passive_sender_takes_a_frame_from_the_third_intermission_bit_after_an_error",
        f"{FC}:test_fc06_and_fc06a_dominant_bits_after_the_passive_flag_of_a_sender",
        f"{SPACES}:test_su01_passive_sender_suspends_eight_bits",
        *[f"{SPACES}:test_im02_passive_former_sender_receives_and_acknowledges"] * 3,
        f"{SPACES}:test_su02_no_suspend_after_lost_arbitration",
        f"{SPACES}:test_im02_passive_former_sender_receives_and_acknowledges",
        f"{STATES}:test_fc10_bus_off_has_no_influence_on_the_bus",
        f"{STATES}:test_fc12_a_dominant_bit_restarts_only_the_present_sequence",
        f"{FLAGS}:test_ef04_up_to_five_dominant_bits_restart_the_passive_flag",
        f"{SENDERS}:test_fc03_sender_finds_its_error_delimiter_corrupted",
        f"{FLAGS}:test_ef07_passive_sender_whose_flag_is_followed_by_an_active_flag_repeats_after_31_bits",
        f"{FLAGS}:test_ef07_node_turned_passive_by_the_error",
    ],
    "8.6": [
        f"{FC}:test_fc04_bit_error_in_the_active_error_flag_of_a_sender",
        f"{FC}:test_fc04_bit_error_in_the_overload_flag_of_a_sender",
        f"{FC}:test_fc06_and_fc06a_dominant_bits_after_the_active_flag_of_a_sender",
        f"{SENDERS}:test_fc06_and_fc06a_dominant_bits_after_the_overload_flag_of_a_sender",
        f"{FC}:test_fc06_and_fc06a_dominant_bits_after_the_passive_flag_of_a_sender",
        *[f"{FC}:test_fc03_sender_counts_eight_and_repeats"] * 2,
        f"{FC}:test_fc03_missing_acknowledgement",
        f"{SENDERS}:test_fc03_sender_finds_its_error_delimiter_corrupted",
        f"{SENDERS}:test_fc03_sender_finds_its_overload_delimiter_corrupted",
        *[f"{STATES}:test_fc07_successful_transmission"] * 2,
        f"{FC}:test_fc06_and_fc06a_dominant_bits_after_the_active_flag_of_a_sender",
        f"{SENDERS}:test_fc06_and_fc06a_dominant_bits_after_the_overload_flag_of_a_sender",
        *[f"{STATES}:test_fc13_sender_counts_nothing_at_the_last_bit_of_a_delimiter"] * 2,
        f"{FC}:test_fc03x1_passive_sender_without_acknowledgement",
        f"{FC}:test_fc03x1n_dominant_bit_in_the_passive_flag_cancels_the_exception",
        f"{FC}:test_fc03x2_stuff_error_in_arbitration",
        f"{STATES}:test_fc13_lost_arbitration_and_then_an_error",
        f"{STATES}:test_fc13_transmission_leaves_rec_and_reception_leaves_tec",
    ],
    "9.6": [f"{STATES}:test_fc14_counters_are_independent"] * 2,
}
NAMES = {
    f"iso_{clause.replace('.', '_')}_{number}": test
    for clause, tests in TESTS.items()
    for number, test in enumerate(tests, start=1)
}
BIT_TIMING = {
    "iso_7_7_1": f"{TIMING}:test_bt01_iso_7_7_1_sample_point",
    "iso_7_7_2": f"{TIMING}:test_bt01_iso_7_7_2_hard_synchronisation_at_sof",
    "iso_7_7_3": f"{TIMING}:test_bt01_iso_7_7_3_iso_7_7_4_late_edge_lengthens_by_the_phase_error_up_to_the_jump_width",
    "iso_7_7_4": f"{TIMING}:test_bt01_iso_7_7_3_iso_7_7_4_late_edge_lengthens_by_the_phase_error_up_to_the_jump_width",
    "iso_7_7_5": f"{TIMING}:test_bt01_iso_7_7_5_iso_7_7_6_early_edge_shortens_by_the_phase_error_up_to_the_jump_width",
    "iso_7_7_6": f"{TIMING}:test_bt01_iso_7_7_5_iso_7_7_6_early_edge_shortens_by_the_phase_error_up_to_the_jump_width",
    "iso_7_7_7": f"{TIMING}:test_bt01_iso_7_7_7_one_synchronisation_between_two_samples",
    "iso_7_7_8": f"{TIMING}:test_bt01_iso_7_7_8_second_edge_after_an_early_one_moves_nothing",
    "iso_7_7_10": f"{TIMING}:test_bt01_iso_7_7_10_no_synchronisation_on_a_glitch_in_a_dominant_bit",
    "iso_7_7_11": f"{TIMING}:test_bt01_iso_7_7_11_early_edge_in_the_acknowledge_slot",
    "iso_8_7_1": f"{TIMING}:test_bt01_iso_8_7_1_sample_point_of_a_sender",
    "iso_8_7_4": f"{TIMING}:test_bt01_iso_8_7_4_early_edge_at_a_sender",
    "iso_8_7_7": f"{TIMING}:test_bt01_iso_8_7_7_sender_ignores_the_delay_of_its_own_dominant_bits",
}
"""Bit timing in time quanta. Not tested one by one: the other names of 7.7 and 8.7, which repeat these in other bits
and roles; 7.8 with its 26 names for both phases of CAN FD, of which the change of rate and the hard synchronisation at
res have tests; 8.8, the second sample point of senders, which the model does not have."""


def names_of(test: str) -> list[str]:
    """Published names that a test, ``module:function``, stands for."""
    return [name for table in (NAMES, BIT_TIMING) for name, stands in table.items() if stands == test]
