"""Every public kernel has a twin: a test that holds it against NumPy, SciPy or another library.

One line per kernel: the room's module, the kernel, the test and, after "by", the package's function through
which the test reaches it where it does not call the kernel itself. A kernel without a line fails, and so does
a line whose kernel or test is gone. Kernels that only their own file calls are private: their twins are those
of the kernels that call them.
"""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

import pytest

import surefoot

TESTS = Path(__file__).parents[1]
SOURCES = Path(surefoot.__file__).parent
DECORATORS = {"kernel", "inline_kernel", "releasing_kernel"}

TABLE = """
audit.slides             slide_on             audit/test_laws.py::test_free_slides_kernel_against_plain_numpy by free_slides
batch.active             add_product          batch/test_batch.py::test_kernels_match_their_numpy_twin by contact_vjp
batch.active             fill                 batch/test_batch.py::test_kernels_match_their_numpy_twin by contact_vjp
batch.active             gather               batch/test_batch.py::test_kernels_match_their_numpy_twin by contact_vjp
batch.active             least_squares        batch/test_batch.py::test_redundant_contacts_in_a_batch by solve_batch
batch.active             list_unknowns        batch/test_batch.py::test_kernels_match_their_numpy_twin by contact_vjp
batch.active             read_modes           batch/test_batch.py::test_kernels_match_their_numpy_twin by contact_vjp
batch.active             regular_pivots       batch/test_batch.py::test_kernels_match_their_numpy_twin by contact_vjp
batch.active             scatter              batch/test_batch.py::test_kernels_match_their_numpy_twin by contact_vjp
batch.active             unscale              batch/test_batch.py::test_kernels_match_their_numpy_twin by contact_vjp
batch.central_path       follow_path          batch/test_central_path.py::test_the_point_and_its_derivative_are_those_of_the_interior_point
batch.central_path       path_blocks          batch/test_central_path.py::test_the_point_and_its_derivative_are_those_of_the_interior_point
batch.kernel             contact_blocks       batch/test_batch.py::test_dense_blocks_are_those_of_the_derivative
batch.kernel             contact_jvp          batch/test_batch.py::test_kernels_match_their_numpy_twin
batch.kernel             contact_vjp          batch/test_batch.py::test_kernels_match_their_numpy_twin
batch.kernel             jvp_within           batch/test_batch.py::test_kernels_match_their_numpy_twin by contact_jvp
batch.kernel             slope_memory         batch/test_batch.py::test_kernels_match_their_numpy_twin by contact_vjp
batch.kernel             solve_contacts       batch/test_batch.py::test_the_kernel_runs_in_a_callers_own_code
batch.kernel             solve_within_memory  batch/test_batch.py::test_the_kernel_runs_in_a_callers_own_code by solve_contacts
batch.kernel             solving_memory       batch/test_batch.py::test_the_kernel_runs_in_a_callers_own_code by solve_contacts
batch.kernel             vjp_within           batch/test_batch.py::test_kernels_match_their_numpy_twin by contact_vjp
batch.loops              derive_range         batch/test_batch.py::test_a_batch_is_its_problems by solve_batch
batch.loops              measure_range        batch/test_batch.py::test_kinks_in_a_batch_are_one_sided by solve_batch
batch.loops              solve_range          batch/test_batch.py::test_a_batch_is_its_problems by solve_batch
collision.manifold       manifolds            collision/test_manifold.py::test_contacts_lie_on_both_surfaces by PairSearch
collision.pairs          place_solids         collision/test_pairs.py::test_solids_are_placed_and_near_ones_found
cones.double_description polar_rays           cones/test_representation.py::test_engines_agree_with_exact_rationals by from_rays
cones.nearest            nearest_points       cones/test_nearest.py::test_nearest_points
contact.admissible       dissipation_limit    contact/test_contact_residuals.py::test_velocity_error_is_its_definition by residuals
contact.admissible       length               contact/test_contact_residuals.py::test_velocity_error_is_its_definition by residuals
contact.admissible       nearest              contact/test_contact_residuals.py::test_velocity_error_is_its_definition by residuals
contact.blocks           block_determinant    conformance/test_small_kernels.py::test_block_determinant
contact.blocks           block_product        solvers/test_solver_kernels.py::test_block_kernels
contact.blocks           checked_copy         solvers/test_solver_kernels.py::test_a_checked_copy_says_what_the_checked_mirror_says
contact.blocks           checked_mirror       solvers/test_solver_kernels.py::test_block_kernels
contact.blocks           dense_blocks         solvers/test_solver_kernels.py::test_block_kernels by blocks
contact.blocks           vectors_fit          conformance/test_small_kernels.py::test_vectors_fit
contact.residuals        certify_dense        contact/test_contact_residuals.py::test_velocity_error_is_its_definition by residuals
contact.scales           scales_blocks        contact/test_scales.py::test_speeds_are_those_of_connected_parts
contact.scales           scales_dense         contact/test_scales.py::test_speeds_are_those_of_connected_parts by scales
contact.scales           symmetric_norm       contact/test_scales.py::test_the_norm_of_a_block_is_numpys
equilibrium.allocation       draw_to_parallel     control/test_standing.py::test_draw_to_parallel_kernel_against_plain_numpy
control.damping          computable           control/test_whole_body_kernels.py::test_only_states_of_finite_size_are_computable
control.feet_kernels follow_phases            control/test_feet_kernels.py::test_feet_are_followed_one_by_one
control.force_ramps ramp_shares              control/test_feet_kernels.py::test_ramps_rise_and_fall
control.feet_kernels set_timing               control/test_feet_kernels.py::test_timing_tells_late_feet
control.foothold         raibert              control/test_walking_kernels.py::test_a_step_goes_where_raibert_puts_it_about_the_coming_hip
control.foothold         step_place           control/test_walking_kernels.py::test_a_step_goes_where_raibert_puts_it_about_the_coming_hip
control.force_ramps      mean_shares          control/test_force_ramps.py::test_mean_shares_are_means
drive.latency          fitting              drive/test_wiring.py::test_the_delay_that_fits_is_that_of_plain_sums
drive.latency          note                 drive/test_wiring.py::test_the_delay_that_fits_is_that_of_plain_sums
control.mpc_model        add_wrench           control/test_mpc_model.py::test_the_condensed_cost_is_the_cost_of_the_march by program
control.mpc_model        advance              control/test_mpc_model.py::test_remembered_points_move_with_time
control.mpc_model        build                control/test_mpc_model.py::test_the_condensed_cost_is_the_cost_of_the_march by program
control.mpc_model        expected_sway        control/test_mpc_model.py::test_the_expected_sway_settles
control.mpc_model        finish               control/test_mpc_model.py::test_the_prediction_is_the_march by solve
control.mpc_model        hessians             control/test_mpc_model.py::test_the_hessian_is_that_of_simulated_errors
control.mpc_model        predict              control/test_mpc_model.py::test_the_prediction_is_the_march by solve
control.standing_kernels foot_impedance       control/test_standing.py::test_foot_impedance_kernel_against_plain_numpy
control.standing_kernels grasp_map_of_points  control/test_standing.py::test_grasp_map_kernel
control.standing_kernels pd_wrench            control/test_standing.py::test_pd_wrench_kernel_against_plain_numpy
control.standing_kernels within_limits        control/test_standing.py::test_within_limits_kernel
control.swing            minimum_jerk         control/test_swing.py::test_the_smooth_step_is_the_minimum_jerk_polynomial
control.swing            sinking              control/test_swing.py::test_the_foot_meets_the_ground_with_its_descent by swing_motion
control.swing            swing_motion         control/test_swing.py::test_velocity_and_acceleration_are_derivatives
control.swing            swing_places         control/test_swing.py::test_places_along_a_swing_are_those_of_its_motion
control.swing            even_swing           control/test_swing.py::test_those_over_even_ground_are_derivatives by swing_motion
control.swing            ramped_step          control/test_swing.py::test_the_ramped_step_is_the_integral_of_its_acceleration
control.swing            smooth_bump          control/test_swing.py::test_the_bump_is_highest_where_it_says
control.whole_body_step commanded control/test_whole_body_step.py::test_accelerations_obey_their_constraints_and_torques_the_dynamics by torques_of
control.whole_body_step exceeded control/test_whole_body_kernels.py::test_excess_is_told_apart
robot.actuators friction_losses robot/test_motor_kernels.py::test_bounds_and_losses_are_those_of_the_curve
robot.motor_limits hold_to_motors robot/test_motor_kernels.py::test_bounds_and_losses_are_those_of_the_curve
robot.motor_limits motor_bounds robot/test_motor_kernels.py::test_bounds_and_losses_are_those_of_the_curve
control.whole_body_step recover control/test_whole_body_kernels.py::test_torques_are_those_of_the_dynamics
robot.actuators torque_range robot/test_motor_kernels.py::test_the_usable_range_is_within_motors_and_command
control.walking_kernels  advance_body         control/test_feet_kernels.py::test_a_body_goes_where_it_should
control.walking_kernels  body_rise            control/test_feet_kernels.py::test_a_body_goes_where_it_should
stance.gait mode_rows stance/test_gait.py::test_rows_of_a_repeated_table_are_those_of_the_schedule by horizon
control.walking_kernels  cruise               control/test_walking_kernels.py::test_a_steady_body_moves_along_chords_of_its_arc
control.walking_kernels  follow               control/test_walking_kernels.py::test_a_body_is_led_back_to_its_motion
control.walking_kernels  plane_through        control/test_walking_kernels.py::test_the_plane_is_that_of_least_squares
control.walking_kernels  slope_frames         control/test_foothold.py::test_the_slope_rotation_is_a_rotation_along_the_surface
control.walking_kernels  stance_places        control/test_walking_kernels.py::test_feet_stand_where_they_are_until_they_have_flown
control.walking_kernels  swing_accelerations  control/test_walking_kernels.py::test_feet_in_the_air_follow_their_paths
control.walking_kernels  swing_paths          control/test_walking_kernels.py::test_feet_in_the_air_follow_their_paths
control.walking_kernels  turned_arms          control/test_walking_kernels.py::test_feet_stand_where_they_are_until_they_have_flown
control.whole_body_kernels base_tasks         control/test_whole_body_kernels.py::test_tasks_are_the_sum_of_their_squares
control.whole_body_kernels contact_rows       control/test_whole_body_kernels.py::test_contact_rows
control.whole_body_kernels eliminate          control/test_whole_body.py::test_elimination_matches_a_plain_kkt_solve
control.whole_body_kernels feet_motion        control/test_whole_body_kernels.py::test_feet_motion
control.whole_body_kernels place_points       control/test_whole_body_kernels.py::test_contact_points_are_on_their_feet
control.whole_body_kernels swing_tasks        control/test_whole_body_kernels.py::test_tasks_are_the_sum_of_their_squares
control.whole_body_step force_problem         control/test_whole_body_step.py::test_accelerations_obey_their_constraints_and_torques_the_dynamics
control.whole_body_step kinematics            control/test_whole_body_step.py::test_kinematics_are_those_of_pinocchio
control.whole_body_step reduce                control/test_whole_body_step.py::test_accelerations_obey_their_constraints_and_torques_the_dynamics
control.whole_body_step torques_of            control/test_whole_body_step.py::test_accelerations_obey_their_constraints_and_torques_the_dynamics
equilibrium.cone_program minimise             equilibrium/test_cone_program.py::test_value_equals_clarabels_and_the_gap_closes
equilibrium.batch         stand_each           equilibrium/test_batch.py::test_one_stance_among_many_is_that_stance_bit_by_bit by can_stand_batch
equilibrium.margin       axis_scale           equilibrium/test_equilibrium_kernels.py::test_scales_of_a_stance
equilibrium.margin       depth                equilibrium/test_equilibrium_kernels.py::test_steps_end_at_the_boundary_and_depth_is_the_way_to_it
equilibrium.margin       load_scale           equilibrium/test_equilibrium_kernels.py::test_scales_of_a_stance
equilibrium.margin       most_margin          equilibrium/test_can_stand.py::test_pyramid_verdicts_agree_with_highs by agreement
equilibrium.margin       proof_reach          equilibrium/test_equilibrium_kernels.py::test_the_reach_of_a_proof_is_a_lower_bound_that_a_linear_program_confirms
equilibrium.margin       spread               equilibrium/test_equilibrium_kernels.py::test_scales_of_a_stance
equilibrium.margin       stand                equilibrium/test_can_stand.py::test_exact_verdicts_agree_with_clarabel by agreement
equilibrium.outline      trace                equilibrium/test_regions.py::test_region_lies_between_inner_and_outer_pyramids_by_linear_programs by com_region
equilibrium.polygons     enclose              equilibrium/test_equilibrium_kernels.py::test_the_hull_is_qhulls_and_the_gap_that_of_the_outer_corners
equilibrium.polygons     hull                 equilibrium/test_equilibrium_kernels.py::test_the_hull_is_qhulls_and_the_gap_that_of_the_outer_corners
equilibrium.polygons     intersection         equilibrium/test_equilibrium_kernels.py::test_half_planes_meet_where_qhull_says
equilibrium.polygons     to_segment           equilibrium/test_equilibrium_kernels.py::test_the_hull_is_qhulls_and_the_gap_that_of_the_outer_corners by enclose
equilibrium.polygons     without_flat_corners equilibrium/test_regions.py::test_polygons
equilibrium.scaling      apply                equilibrium/test_equilibrium_kernels.py::test_the_scaling_takes_both_points_to_the_same
equilibrium.scaling      corrector_target     equilibrium/test_equilibrium_kernels.py::test_the_corrector_solves_the_jordan_equation
equilibrium.scaling      scale                equilibrium/test_equilibrium_kernels.py::test_the_scaling_takes_both_points_to_the_same
equilibrium.scaling      step_to_boundary     equilibrium/test_equilibrium_kernels.py::test_steps_end_at_the_boundary_and_depth_is_the_way_to_it
estimation.credible      credible             estimation/test_foot_kinematics.py::test_what_no_robot_has_is_not_credible
estimation.credible      known                estimation/test_foot_kinematics.py::test_what_no_robot_has_is_not_credible
estimation.cube_contact  exchange             estimation/test_cube_motion.py::test_impulses_obey_the_laws_of_the_problem_as_numpy_writes_it
estimation.cube_contact  place                estimation/test_cube_motion.py::test_corners_and_their_speeds_are_those_of_a_rotated_box
estimation.cube_contact  rise                 estimation/test_cube_motion.py::test_corners_and_their_speeds_are_those_of_a_rotated_box
estimation.cube_motion   fly                  estimation/test_cube_motion.py::test_fly_turns_slowly_and_not_at_all
estimation.cube_motion   simulate             estimation/test_cube_motion.py::test_a_step_of_the_kernel_is_one_of_the_rollout
estimation.cube_motion   step                 estimation/test_cube_motion.py::test_a_step_of_the_kernel_is_one_of_the_rollout
estimation.detection_kernels contact_odds     estimation/test_contact_odds.py::test_odds_are_those_of_the_densities
estimation.detection_kernels add_torques      estimation/test_foot_kinematics.py::test_the_observer_is_its_equation by ContactDetector
estimation.detection_kernels decide_contacts  estimation/test_contact_odds.py::test_what_is_told_of_a_force_takes_the_place_of_what_is_felt by ContactFusion
estimation.detection_kernels detector_arrays  estimation/test_foot_kinematics.py::test_the_observer_is_its_equation by ContactDetector
estimation.detection_kernels feel_feet        estimation/test_foot_kinematics.py::test_the_observer_is_its_equation by ContactDetector
estimation.detection_kernels foot_forces      estimation/test_foot_kinematics.py::test_forces_are_damped_least_squares
estimation.detection_kernels prior_odds       estimation/test_contact_odds.py::test_what_is_told_of_a_force_takes_the_place_of_what_is_felt by ContactFusion
estimation.elevation_kernels bilinear         estimation/test_elevation_map.py::test_heights_between_cells_are_bilinear
estimation.elevation_kernels fill_unknown     estimation/test_elevation_map.py::test_unknown_cells_take_the_lowest_nearby_or_the_plane
estimation.elevation_kernels flight_heights   estimation/test_flight_fit.py::test_heights_on_a_flight_are_those_of_its_steps
estimation.elevation_kernels fuse_points      estimation/test_elevation_map.py::test_points_are_fused_one_by_one
estimation.elevation_kernels leave_out_strays estimation/test_elevation_map.py::test_lone_cells_need_a_neighbour_that_is_as_high
estimation.extended_poses apply               estimation/test_extended_poses.py::test_apply_is_a_product
estimation.extended_poses gammas              estimation/test_extended_poses.py::test_gammas_are_their_series
estimation.extended_poses move                estimation/test_extended_poses.py::test_product_inverse_and_move_are_the_matrices
estimation.foot_kinematics base_state         estimation/test_foot_kinematics.py::test_base_state_and_speeds_over_ground
estimation.foot_kinematics feet_by_joints     estimation/test_foot_kinematics.py::test_feet_by_joints_is_its_sum
estimation.foot_kinematics foot_arrays          estimation/test_foot_kinematics.py::test_places_speeds_and_spreads_are_those_of_differences by FootKinematics
estimation.foot_kinematics follow_stances       estimation/test_foot_kinematics.py::test_stances_have_an_age
estimation.foot_kinematics over_ground        estimation/test_foot_kinematics.py::test_base_state_and_speeds_over_ground
estimation.foot_kinematics place_feet           estimation/test_foot_kinematics.py::test_places_speeds_and_spreads_are_those_of_differences by FootKinematics
estimation.foot_kinematics places_seen          estimation/test_foot_kinematics.py::test_places_are_seen_from_the_imu_and_less_what_has_rolled
estimation.foot_kinematics roll               estimation/test_foot_kinematics.py::test_a_sphere_rolls_as_far_as_it_turns
estimation.foot_kinematics state_ahead          estimation/test_foot_kinematics.py::test_the_state_ahead_is_that_of_its_parts
estimation.friction  follow_friction      estimation/test_friction_tracker.py::test_kernel_against_plain_python
estimation.inekf_kernels add_foot             estimation/test_inekf.py::test_a_new_foots_error_is_that_of_its_place
estimation.inekf_kernels correct              estimation/test_inekf.py::test_a_correction_is_the_textbooks
estimation.inekf_kernels correct_height       estimation/test_inekf.py::test_a_known_height_is_a_correction_with_one_row
estimation.inekf_kernels foresee              estimation/test_inekf.py::test_the_state_alone_goes_on_as_with_its_covariance
estimation.inekf_kernels forget_foot          estimation/test_inekf.py::test_a_new_foots_error_is_that_of_its_place
estimation.inekf_kernels observe_feet         estimation/test_inekf.py::test_feet_are_forgotten_used_and_added_one_after_the_other
estimation.inekf_kernels propagate            estimation/test_inekf.py::test_propagation_is_that_of_plain_matrices
estimation.step_kernels advance               estimation/test_state_estimator.py::test_a_step_is_that_of_its_parts by StateEstimator
estimation.step_kernels filter_arrays         estimation/test_state_estimator.py::test_a_step_is_that_of_its_parts by StateEstimator
estimation.step_kernels robot_arrays          estimation/test_state_estimator.py::test_a_step_is_that_of_its_parts by StateEstimator
estimation.step_kernels settle                estimation/test_state_estimator.py::test_a_step_is_that_of_its_parts by StateEstimator
estimation.step_kernels stand                 estimation/test_state_estimator.py::test_a_step_is_that_of_its_parts by StateEstimator
estimation.step_kernels tell                  estimation/test_state_estimator.py::test_a_step_is_that_of_its_parts by StateEstimator
estimation.step_kernels waiting_arrays        estimation/test_state_estimator.py::test_a_step_is_that_of_its_parts by StateEstimator
estimation.wrench_kernels add_weight          estimation/test_wrench_observer.py::test_the_weight_of_a_load_is_force_and_moment
estimation.wrench_kernels filter_block         estimation/test_wrench_observer.py::test_blocks_are_filtered_with_the_spread_of_their_differences
estimation.wrench_kernels point_inertia        estimation/test_wrench_observer.py::test_a_sum_of_wrenches_is_of_those_of_its_steps
estimation.wrench_kernels sum_wrench           estimation/test_wrench_observer.py::test_a_sum_of_wrenches_is_of_those_of_its_steps
estimation.wrench_kernels filter_wrench       estimation/test_wrench_observer.py::test_the_filters_step_is_kalmans
estimation.wrench_kernels outside_wrench      estimation/test_wrench_observer.py::test_a_known_wrench_is_what_the_equations_of_motion_leave by seen
estimation.wrench_kernels tell_wrench         control/test_load_adaptation.py::test_of_a_wrench_no_more_is_told_than_the_bound by pull
numerics.cholesky        cholesky             numerics/test_cholesky.py::test_factor_and_solves
numerics.cholesky        guarded_cholesky     numerics/test_cholesky.py::test_the_guarded_factor_is_the_plain_one_and_tells_its_least_pivot
numerics.cholesky        invert               numerics/test_cholesky.py::test_factor_and_solves
numerics.cholesky        product              numerics/test_cholesky.py::test_product
numerics.cholesky        solve_columns        numerics/test_cholesky.py::test_factor_and_solves
numerics.cholesky        solve_lower          numerics/test_cholesky.py::test_factor_and_solves
numerics.cholesky        solve_upper          numerics/test_cholesky.py::test_factor_and_solves
numerics.elimination     invert_shifted       numerics/test_elimination.py::test_inverse_is_numpy_inverse
numerics.elimination     lu_solve             numerics/test_elimination.py::test_lu_is_numpy_solve
numerics.elimination     lu_solve_many        numerics/test_elimination.py::test_elimination_of_many_right_hand_sides_is_numpy_solve
numerics.elimination     symmetric_solve      numerics/test_elimination.py::test_symmetric_elimination_is_numpy_solve
numerics.factorisation   factor               numerics/test_factorisation.py::test_the_factorisation_solves
numerics.factorisation   solve_factored       numerics/test_factorisation.py::test_the_factorisation_solves
numerics.line_search     search               numerics/test_line_search.py::test_smooth_derivatives_end_as_near_as_asked
numerics.orthogonal      coordinates          numerics/test_orthogonal.py::test_reduction_finds_the_rank_and_factors
numerics.orthogonal      orthonormal_rows     numerics/test_orthogonal.py::test_reduction_finds_the_rank_and_factors
numerics.orthogonal      pull_back            numerics/test_orthogonal.py::test_reduction_finds_the_rank_and_factors
numerics.orthogonal      reflect              numerics/test_orthogonal.py::test_turning_the_first_row
numerics.orthogonal      remove_rows          numerics/test_orthogonal.py::test_what_lies_along_earlier_rows_is_removed
numerics.orthogonal      scale_row            numerics/test_orthogonal.py::test_what_lies_along_earlier_rows_is_removed
numerics.orthogonal      turn_first_row       numerics/test_orthogonal.py::test_turning_the_first_row
numerics.points          contact_jacobian     numerics/test_points.py::test_velocities_and_their_jacobians
numerics.points          point_jacobian       numerics/test_points.py::test_velocities_and_their_jacobians
numerics.points          point_velocity       numerics/test_points.py::test_velocities_and_their_jacobians
numerics.points          relative_jacobian    numerics/test_points.py::test_jacobian_of_one_body_against_another
numerics.projection      differential         numerics/test_projection.py::test_generalised_jacobian
numerics.projection      face                 numerics/test_projection.py::test_generalised_jacobian
numerics.projection      project_cone         numerics/test_projection.py::test_projection
numerics.projection      project_truncated    numerics/test_projection.py::test_projection
numerics.rotations       log_between          numerics/test_rotations.py::test_the_rotation_vector_is_scipys
numerics.rotations       rotation_of planning/shooting/test_costs.py::test_differences_and_retractions_are_inverse_and_pinocchios_to_first_order by difference
numerics.six             add_outer            numerics/test_six.py::test_six_dimensional_algebra
numerics.six             dot                  numerics/test_six.py::test_six_dimensional_algebra
numerics.six             mix                  numerics/test_six.py::test_six_dimensional_algebra
numerics.six             scale                numerics/test_six.py::test_six_dimensional_algebra
numerics.six             scaled_identity      numerics/test_six.py::test_six_dimensional_algebra
numerics.six             solve_six            numerics/test_six.py::test_six_dimensional_algebra
numerics.six             times                numerics/test_six.py::test_six_dimensional_algebra
numerics.vectors         advance              numerics/test_points.py::test_vectors
numerics.vectors         cross                numerics/test_points.py::test_vectors
numerics.vectors         dot                  numerics/test_points.py::test_vectors
planning.mpc.receding move_on planning/mpc/test_receding.py::test_a_plan_moved_on_is_read_between_its_knots
planning.mpc.receding torques_between planning/mpc/test_receding.py::test_torques_between_knots_feed_the_distance_from_the_planned_state_back
planning.shooting.cost_kernels cost_slopes planning/shooting/test_costs.py::test_cost_gradient_and_hessian_are_those_of_the_residuals
planning.shooting.cost_kernels motion_cost planning/shooting/test_costs.py::test_cost_gradient_and_hessian_are_those_of_the_residuals by price
planning.shooting.cost_kernels state_error planning/shooting/test_costs.py::test_cost_gradient_and_hessian_are_those_of_the_residuals by price
planning.shooting.riccati backward_pass planning/shooting/test_riccati.py::test_the_kernel_is_the_textbook_recursion_with_dense_matrices by run
planning.shooting.riccati solve_box planning/shooting/test_riccati.py::test_box_programs_against_scipy
planning.shooting.state_space defect planning/shooting/test_costs.py::test_differences_and_retractions_are_inverse_and_pinocchios_to_first_order
planning.shooting.state_space difference planning/shooting/test_costs.py::test_differences_and_retractions_are_inverse_and_pinocchios_to_first_order
planning.shooting.state_space feedback planning/shooting/test_costs.py::test_feedback_is_the_policy_within_its_limits
planning.shooting.state_space retract planning/shooting/test_costs.py::test_differences_and_retractions_are_inverse_and_pinocchios_to_first_order
planning.shooting.state_space turn_between planning/shooting/test_costs.py::test_differences_and_retractions_are_inverse_and_pinocchios_to_first_order by difference
simulation.mujoco_actuators load_joints       simulation/test_run_kernels.py::test_joints_are_loaded_with_what_motors_give
simulation.mujoco_contacts face_principal     simulation/test_mujoco_substeps.py::test_a_foot_in_a_corner_tells_of_what_bears_more
simulation.mujoco_contacts toward             simulation/test_mujoco_substeps.py::test_a_foot_in_a_corner_tells_of_what_bears_more by face_principal
simulation.mujoco_contacts read_contacts      simulation/test_mujoco.py::test_contact_forces_are_mujocos_own by contacts
simulation.mujoco_contacts to_pinocchio       simulation/test_mujoco.py::test_state_survives_the_round_trip by state
simulation.mujoco_links  feet_on_ground       simulation/test_mujoco_links.py::test_rows_are_sorted_as_by_plain_numpy
simulation.mujoco_links  other_rows           simulation/test_mujoco_links.py::test_rows_are_sorted_as_by_plain_numpy
simulation.run_kernels   any_reached          simulation/test_run_kernels.py::test_loaded_feet_and_torques_at_limits
simulation.run_kernels   loaded_feet          simulation/test_run_kernels.py::test_loaded_feet_and_torques_at_limits
simulation.sensor_kernels counted              simulation/test_sensors.py::test_readings_are_those_of_plain_numpy
simulation.sensor_kernels imu_reading          simulation/test_sensors.py::test_readings_are_those_of_plain_numpy
simulation.sensor_kernels heard                simulation/test_sensors.py::test_a_row_of_readings_is_that_of_its_parts by Sensors
simulation.sensor_kernels mean_readings       simulation/test_sensors.py::test_mean_readings_are_those_of_matrices
simulation.sensor_kernels sense                simulation/test_sensors.py::test_a_row_of_readings_is_that_of_its_parts by Sensors
simulation.sensor_kernels with_points          simulation/test_sensors.py::test_feet_with_active_points_are_found
solvers.admm             next_penalty         conformance/test_small_kernels.py::test_the_penalty_follows_the_relative_residuals
solvers.compiled         read_system          solvers/test_contact_solver.py::test_answers_are_those_of_solve by solve
solvers.compiled         solve_compiled       conformance/test_contact_axioms.py::test_the_convex_law_is_the_cone_program by solve
solvers.compiled         solve_within         conformance/test_contact_axioms.py::test_the_convex_law_is_the_cone_program by solve
solvers.dual_newton.dense minimise            solvers/test_dual_newton.py::test_general_newton_matches_the_six_dimensional_one
solvers.dual_newton.horizon newton            solvers/test_dual_newton_horizon.py::test_the_answer_is_a_fixed_point_of_projected_gradients
solvers.dual_newton.method descend            solvers/test_dual_newton_method.py::test_newton_finds_the_root_and_the_points_are_those_of_it
solvers.dual_newton.method follow_path        solvers/test_dual_newton_method.py::test_the_path_ends_at_the_same_root
solvers.dual_newton.rows distribute_with_rows equilibrium/test_force_distribution_torques.py::test_torque_limits_against_clarabel by solve
solvers.dual_newton.rows row_violation        solvers/test_dual_newton_rows.py::test_row_violation_and_limits
solvers.dual_newton.work column               solvers/test_dual_newton_work.py::test_rows_hold_what_is_stored
solvers.dual_newton.work combine              solvers/test_dual_newton_work.py::test_rows_hold_what_is_stored
solvers.dual_newton.work hold                 solvers/test_dual_newton_work.py::test_holding_brings_the_last_command_into_the_cones
solvers.dual_newton.work load                 solvers/test_dual_newton_work.py::test_a_grasp_map_is_loaded_in_scaled_units
solvers.dual_newton.work measure              solvers/test_dual_newton_work.py::test_what_is_left_of_the_wrench
solvers.dual_newton.work predict              solvers/test_dual_newton.py::test_a_steady_change_is_foretold_and_noise_is_not
solvers.dual_newton.work project              solvers/test_dual_newton_work.py::test_holding_brings_the_last_command_into_the_cones
solvers.dual_newton.work remainder            solvers/test_dual_newton_work.py::test_what_is_left_of_the_wrench
solvers.dual_newton.work remember             solvers/test_dual_newton.py::test_a_steady_change_is_foretold_and_noise_is_not
solvers.dual_newton.work set_limits           solvers/test_dual_newton_rows.py::test_row_violation_and_limits
solvers.dual_newton.work store                solvers/test_dual_newton_work.py::test_rows_hold_what_is_stored
solvers.dual_newton.work store_vector         solvers/test_dual_newton_work.py::test_rows_hold_what_is_stored
solvers.dual_newton.work unload               solvers/test_dual_newton_work.py::test_forces_leave_in_newtons_and_within_their_bounds
solvers.dual_newton.work vector               solvers/test_dual_newton_work.py::test_rows_hold_what_is_stored
solvers.dual_newton.work weigh                solvers/test_dual_newton_work.py::test_a_grasp_map_is_loaded_in_scaled_units
solvers.dual_newton.wrench distribute_wrench  solvers/test_dual_newton.py::test_newton_against_the_same_in_numpy
solvers.newton_step      classify             solvers/test_solver_kernels.py::test_newton_step_solves_the_linearised_equations by newton_dense
solvers.newton_step      newton_dense         solvers/test_solver_kernels.py::test_newton_step_solves_the_linearised_equations
solvers.newton_step      run_dense            conformance/test_contact_axioms.py::test_the_convex_law_is_the_cone_program by solve
solvers.newton_step      spread               solvers/test_solver_kernels.py::test_newton_step_solves_the_linearised_equations by newton_dense
solvers.nsgs             fill_dense           solvers/test_solver_kernels.py::test_sweeps_dense_and_blocks by prepare_dense
solvers.nsgs             prepare_blocks       solvers/test_solver_kernels.py::test_sweeps_dense_and_blocks
solvers.nsgs             prepare_dense        solvers/test_solver_kernels.py::test_sweeps_dense_and_blocks
solvers.nsgs             refresh_dense        solvers/test_solver_kernels.py::test_block_kernels
solvers.nsgs             relaxation           conformance/test_small_kernels.py::test_relaxation_halves_where_sweeps_go_in_circles
solvers.nsgs             run_blocks           conformance/test_small_kernels.py::test_sweeps_end_where_projected_steps_end
solvers.nsgs             run_dense            conformance/test_small_kernels.py::test_sweeps_end_where_projected_steps_end
solvers.nsgs             sweep_blocks         solvers/test_solver_kernels.py::test_sweeps_dense_and_blocks
solvers.nsgs             sweep_dense          solvers/test_solver_kernels.py::test_sweeps_dense_and_blocks
solvers.one_contact      block_of             solvers/test_solver_kernels.py::test_sweeps_dense_and_blocks by sweep_dense
solvers.one_contact      prepare              solvers/test_one_contact.py::test_prepare_inverts_the_block
solvers.one_contact      slide_one            solvers/test_one_contact.py::test_matches_a_projected_fixed_point by solve_one
solvers.one_contact      solve_one            solvers/test_one_contact.py::test_matches_a_projected_fixed_point
solvers.pyramid          project_any          solvers/test_solver_kernels.py::test_pyramid_projection_and_shift
solvers.pyramid          sector               solvers/test_solver_kernels.py::test_pyramid_projection_and_shift by project_any
solvers.pyramid          shift_any            solvers/test_solver_kernels.py::test_pyramid_projection_and_shift
solvers.set_kernels      jacobian_sets        solvers/test_set_kernels.py::test_projection_shift_and_jacobian_are_those_of_the_contacts
solvers.set_kernels      natural_sets         solvers/test_set_kernels.py::test_newton_matrix_is_the_derivative_of_the_natural_map by measure
solvers.set_kernels      newton_matrix        solvers/test_set_kernels.py::test_newton_matrix_is_the_derivative_of_the_natural_map
solvers.set_kernels      project_sets         solvers/test_set_kernels.py::test_projection_shift_and_jacobian_are_those_of_the_contacts
solvers.set_kernels      shift_sets           solvers/test_set_kernels.py::test_projection_shift_and_jacobian_are_those_of_the_contacts
solvers.stopping         fill_measure         conformance/test_small_kernels.py::test_contacts_without_speed_rest_at_their_least_force
solvers.stopping         force_error          solvers/test_solver_kernels.py::test_projection_and_errors
solvers.stopping         settle               conformance/test_small_kernels.py::test_contacts_without_speed_rest_at_their_least_force
solvers.stopping         velocity_error       solvers/test_solver_kernels.py::test_projection_and_errors
stepping.arithmetic      apply_impulses       stepping/test_arithmetic.py::test_problem_is_the_delassus_operator_with_the_shifted_free_velocity
stepping.arithmetic      assemble             stepping/test_arithmetic.py::test_problem_is_the_delassus_operator_with_the_shifted_free_velocity
stepping.arithmetic      factorise            stepping/test_arithmetic.py::test_factor_and_solves
stepping.arithmetic      free_velocity        stepping/test_arithmetic.py::test_problem_is_the_delassus_operator_with_the_shifted_free_velocity
stepping.arithmetic      largest              stepping/test_arithmetic.py::test_largest_magnitude
stepping.arithmetic      mean_work            conformance/test_small_kernels.py::test_mean_work_and_swerves
stepping.arithmetic      near_ground          stepping/test_arithmetic.py::test_near_ground_takes_what_may_touch
stepping.arithmetic      swerves              conformance/test_small_kernels.py::test_mean_work_and_swerves
stepping.arithmetic      with_missed          stepping/test_arithmetic.py::test_contacts_that_the_others_push_down_join_in
stepping.derivative_kernels centre_rates         stepping/test_derivative_kernels.py::test_rates_are_those_of_pinocchios_jacobians
stepping.derivative_kernels force_rates          stepping/test_derivative_kernels.py::test_rates_are_those_of_pinocchios_jacobians
stepping.derivative_kernels velocity_rates       stepping/test_derivative_kernels.py::test_rates_are_those_of_pinocchios_jacobians
stepping.knot_kernels    answer               stepping/test_first_order.py::test_blocks_are_those_of_differences_and_of_the_knot by step_derivative
stepping.knot_kernels    first_order_blocks   stepping/test_first_order.py::test_blocks_are_those_of_differences_and_of_the_knot by step_derivative
stepping.knot_kernels    first_order_step     stepping/test_first_order.py::test_blocks_are_those_of_differences_and_of_the_knot by step_derivative
stepping.knot_kernels    smooth_step          stepping/test_first_order.py::test_smoothing_is_that_of_the_contact_derivative by step_derivative
stepping.motion          bent                 stepping/test_motion.py::test_cheap_ways_keep_the_tolerance by advance
stepping.motion          bracket              stepping/test_motion.py::test_stage_twin_and_tangent_rate by stage
stepping.motion          halfway              stepping/test_motion.py::test_cheap_ways_keep_the_tolerance by advance
stepping.motion          pair_error           stepping/test_motion.py::test_stage_twin_and_tangent_rate
stepping.motion          stage                stepping/test_motion.py::test_stage_twin_and_tangent_rate
stepping.motion          straight             stepping/test_motion.py::test_cheap_ways_keep_the_tolerance by advance
terrain.frames           surface_frames       stepping/test_arithmetic.py::test_surface_frames_are_those_of_single_normals
terrain.heightfield      bicubic              terrain/test_heightfield_kernel.py::test_heights_match_plain_numpy by height
terrain.heightfield      catmull_rom          terrain/test_heightfield_kernel.py::test_heights_match_plain_numpy by height
"""  # noqa: E501  # one line per kernel

LINES = [line.split() for line in TABLE.strip().splitlines()]


def public_kernels() -> set[tuple[str, str]]:
    """Return module and name of every decorated function without a leading underscore."""
    found = set()
    for path in SOURCES.rglob("*.py"):
        module = ".".join(path.relative_to(SOURCES).with_suffix("").parts)
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
                names = {d.id for d in node.decorator_list if isinstance(d, ast.Name)}
                if names & DECORATORS:
                    found.add((module, node.name))
    return found


@cache
def functions(path: Path) -> dict[str, set[str]]:
    """Return the names that every function of a test file uses, those of its helpers in the file included."""
    used = {}
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef):
            inside = list(ast.walk(node))
            names = {n.id for n in inside if isinstance(n, ast.Name)}
            used[node.name] = names | {n.attr for n in inside if isinstance(n, ast.Attribute)}
    for _ in range(3):
        for names in used.values():
            names |= {more for name in names & set(used) for more in used[name]}
    return used


def test_every_public_kernel_has_a_twin() -> None:
    listed = {(line[0], line[1]) for line in LINES}
    assert len(listed) == len(LINES), "a kernel is listed twice"
    missing, gone = public_kernels() - listed, listed - public_kernels()
    assert not missing, f"without a twin (write one, or make them private): {sorted(missing)}"
    assert not gone, f"listed, but no longer there: {sorted(gone)}"


@pytest.mark.parametrize("line", LINES, ids=lambda line: f"{line[0]}.{line[1]}")
def test_the_twin_is_there_and_reaches_the_kernel(line: list[str]) -> None:
    kernel, where = line[1:3]
    file, _, test = where.partition("::")
    used = functions(TESTS / file)
    assert test in used, f"{file} has no {test}"
    name = line[4] if len(line) > 3 else kernel
    assert name in used[test], f"{test} does not call {name}"
