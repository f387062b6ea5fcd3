"""The numbers of flexmb that are no physics: what docs/numbers.md lists, and what it leaves out and why.

READ are numbers of the sources that `numbers_live` makes readable, varied in the runs that they may reach.  ASKED are
arguments with defaults.  ELSEWHERE are numbers that none of the runs reaches.  LEFT_OUT are constants that are no
thresholds.  A line is: place | unit | what it is measured against | what it stands for | factors, where ten and a
hundred make no sense.
"""

from dataclasses import dataclass

FACTORS = (0.01, 0.1, 10.0, 100.0)


@dataclass(frozen=True)
class Number:
    """A number that is no physics of a model.

    Parameters
    ----------
    place : where it stands, see `numbers_live`; or the argument whose default it is.
    unit : its unit, 1 for none.
    scale : what it is measured against, "nothing" for an absolute number.
    meaning : what it stands for.
    factors : those it is varied by.
    """

    place: str
    unit: str
    scale: str
    meaning: str
    factors: tuple[float, ...] = FACTORS


def _numbers(text: str) -> tuple[Number, ...]:
    """The numbers of lines as described above."""
    found = []
    for line in filter(None, map(str.strip, text.splitlines())):
        place, unit, scale, meaning, *factors = (part.strip() for part in line.split("|"))
        chosen = tuple(map(float, factors[0].split())) if factors else FACTORS
        found.append(Number(place, unit, scale, meaning, chosen))
    return tuple(found)


READ = _numbers("""
contact.gap_crossing.crossing#40 | iterations | nothing | most iterations for the instant of an onset | 0.05 0.1 10
contact.gap_crossing.crossing#1e-15 | 1 | a step | accuracy of the instant of an onset | 0.01 0.1 10 100 1e6
step.newmark.error_control.CONTACT_TRIALS | trials | nothing | most trials of one step that look for a contact | 0.125 0.5 10
step.newmark.error_control.UNCHANGED_FROM | 1 | a step | a step is not shortened for less | 0.1 0.5 1.05
step.newmark.error_control.UNCHANGED_TO | 1 | a step | a step is not lengthened for less | 0.84 1.25 1.6
step.newmark.error_control.velocity_constant#0.02 | 1 | method | floor of the error constant of velocities
step.newmark.error_control.error_ratio#0.05 | 1 | method | floor of the error constant of positions
step.newmark.error_control.node_error#12.0 | 1 | method | error of a first step: change of the acceleration over this
step.newmark.error_control.SAFETY | 1 | a step | safety factor of the next step | 0.1 0.5 1.1
step.newmark.error_control.growth_factor#0.2 | 1 | a step | most that a step is shortened at once | 0.1 0.5 2
step.newmark.error_control.growth_factor#2.0 | 1 | a step | most that a step grows at once | 0.6 2 10
step.newmark.error_control.meets_contacts#0.25 | 1 | a step | what becomes of a step that did not converge | 0.1 0.5 2
step.newmark.redundant_constraints.CLOSED_GAP | 1 | size of the mechanism | gap of a row that may be held
step.newmark.redundant_constraints.OPENING_FRACTION | 1 | way h^2 a | gap of a row that may be held in the first steps
step.newmark.redundant_constraints.HOLD_WITHIN_STEP | 1 | largest term of a pivot | with what rows are held within a step that holds some
step.newmark.redundant_constraints.PASSING_STEPS | steps | nothing | steps that pass a singular position | 0.34 10 100
step.newmark.redundant_constraints.allowed_gap#0.01 | 1 | size of the mechanism | cap of that way
step.contact_events.ONSET_TOLERANCE | 1 | step of an impact | a contact begins, or has ended, within this part of it
step.contact_events.PROBE_FRACTION | 1 | duration of an impact | first trial of an impact
step.contact_events.JUMP_STEP_FRACTION | 1 | step of an impact | step just into a contact whose force jumps
step.contact_events.DURATION_FACTOR | 1 | depth / approach speed | estimate of the duration of an impact | 0.1 0.5 2 10
step.contact_events.LEAST_DURATION_FACTOR | 1 | depth / approach speed | least duration of a first impact | 0.1 0.5 2
step.contact_events.PEAK_ACCELERATION_FACTOR | 1 | approach speed / duration | estimate of the largest acceleration | 0.1 0.5 2 10
step.contact_events.SHORTEN_BELOW | 1 | step of an impact | a step is changed within an impact below this | 0.01 0.1 1.2
step.contact_events.LENGTHEN_ABOVE | 1 | step of an impact | a step is changed within an impact above this | 0.65 10 100
step.contact_events.LONGEST_IMPACT | 1 | estimated duration | an impact that takes longer is left to the error
step.contact_events.LEAST_DEPTH | 1 | size of the mechanism | a dip of a gap below zero that may be round-off
step.contact_events.find_force_jump#0.001 | 1 | depth of a step | depth at which a jump of the force is looked for
step.contact_events.find_force_jump#0.1 | 1 | force of a step | smallest force there that is a jump | 0.01 0.1 9
step.contact_events.step_to_events#1.3 | 1 | steepest change | an impact's step that changes more is refused | 0.1 0.5 10 100
step.contact_events.step_to_events#0.2 | 1 | a step | most that a step within an impact is shortened at once | 0.1 0.5 4
step.contact_events.impact_step#0.5 | 1 | approach speed | rate from which a trial has rebounded | 0.1 0.5 2 10
step.contact_events.impact_step#0.001 | 1 | energy of an approach | least part of it that an impact took
step.contact_events.impact_duration#0.5 | 1 | duration of an impact | what forces of flight make of it | 0.01 0.1 10
step.contact_events.update_impacts#0.4 | 1 | energy of an approach | left of it when the step is checked | 0.01 0.1 2
step.contact_events.update_impacts#0.9 | 1 | energy of an approach | left of it when the step is checked | 0.5 1.1
energy.balance.RESIDUAL_LIMIT | 1 | energy turned over | largest residual of a run that is ok
energy.balance.ALGORITHM_LIMIT | 1 | energy turned over | largest energy that the steps take or make
energy.balance.CONTACT_LIMIT | 1 | energy through contacts | largest energy that the steps take or make there
energy.balance.LEAST_CONTACT_FRACTION | 1 | energy turned over | from here on contacts are judged
energy.balance.UNCHANGED | 1 | kinetic energy of a group of bodies | change up to which it had no part in the motion
energy.balance.COORDINATE_ROUND_OFF | 1 | coordinates | round-off of a coordinate
energy.balance.LEAST_RATE_POWER | 1 | power of dampers | part of it from which differences of rates count
energy.balance.STEPS_BEFORE_CHECK | steps | nothing | steps before the first verdict on energies
energy.balance.energy_scale#1e-06 | 1 | energy of heights | part of it that counts as turned over
energy.balance.energy_supplied#1e-06 | 1 | energy of heights | part of it that counts as put in
step.newmark.newton_correction.ROUND_OFF | 1 | coordinates | corrections below this part are round-off
step.newmark.implicit_step.SMALL_SYSTEM | unknowns | nothing | up to so many, each iteration that rubs has its own matrix
step.newmark.implicit_step.NONLINEAR_CORRECTION | 1 | what is wanted | size of a correction up to which its factors serve a contact
step.newmark.newton_correction.GAP_ROUND_OFF | 1 | round-off of corrections | round-off of a gap
step.newmark.newton_correction.ANGLE_ALLOWANCE | rad | nothing | angles up to here have the round-off of 1 rad
step.newmark.implicit_step.ROUND_OFF_FRACTION | 1 | corrections | noise, and a correction that does not get smaller | 0.01 0.1 5
step.newmark.predictor.FARTHEST_LEAP | 1 | size of the mechanism, or rad | way by predicted accelerations that is no start
step.newmark.predictor.OLD_ERROR_WEIGHT | 1 | what an order missed | weight of what was before the last step | 0.01 0.1 1.9
step.newmark.jacobian_reuse.LONGEST_SUSPENSION | steps | nothing | most steps with new factors after old ones were refused
step.newmark.jacobian_reuse.OLDEST_FACTORS | steps | nothing | factors that served so many go
step.newmark.jacobian_reuse.MOST_EXTRA_ITERATIONS | iterations | nothing | factors that cost so many go
step.newmark.jacobian_reuse.COEFFICIENT_CHANGE | 1 | coefficients of a step | factors whose coefficients differ more go | 0.01 0.1 4
step.newmark.jacobian_reuse.REGULAR_PIVOT | 1 | largest term of a pivot | pivot with which factors may serve again
step.newmark.jacobian_reuse.MEASURING_INTERVAL | steps | nothing | steps after which theta is measured anew
step.newmark.jacobian_reuse.GOOD_CONTRACTION | 1 | corrections | theta with which one correction is believed | 0.01 0.1 9
step.newmark.jacobian_reuse.FAIR_CONTRACTION | 1 | corrections | theta with which iterations go on | 0.01 0.1 3
step.newmark.jacobian_reuse.SLOPE_CHANGE | 1 | slope of a law | largest change of a slope with the same factors | 0.01 0.1 1.9
step.newmark.jacobian_reuse.CORRECTION_GROWTH | 1 | first correction before | one that is larger is not believed alone
step.newmark.jacobian_reuse.MOST_REUSE_ITERATIONS | iterations | nothing | most iterations with old factors | 0.25 10 100
step.newmark.jacobian_reuse.REMAINING_ERROR | 1 | what is wanted | error that a step may be left with
step.newmark.jacobian_reuse.REMAINING_ROUND_OFF | 1 | round-off | the same where round-off is more
step.newmark.jacobian_reuse.NEGLIGIBLE_CORRECTION | 1 | what is wanted | last correction after which forces are not evaluated again
step.newmark.jacobian_reuse.NEGLIGIBLE_WITH_FRICTION | 1 | what is wanted | the same where a contact is closed
step.newmark.jacobian_reuse.first_correction_suffices#0.001 | 1 | what is wanted | a first correction below it has not grown
step.newmark.jacobian_reuse.measure_contraction#0.05 | 1 | what is wanted | below it, theta cannot be told from round-off
run.run.NEWTON_TOLERANCE | 1 | way h^2 a | what is wanted of corrections
run.run.NEWTON_ITERATIONS | iterations | nothing | most iterations of Newton's method | 0.1 0.5 10
run.step_limits.step_limits#0.001 | 1 | size of the mechanism | error of positions over rtol, without clearance
run.step_limits.step_limits#0.01 | 1 | size / largest step | least speed for rtol; cap of the clearance for atol
run.step_limits.step_limits#100.0 | 1 | least clearance | way that the least speed for rtol crosses
run.step_limits.step_limits#1e-09 | 1 | largest step | smallest step
run.step_limits.LEAST_STEP | 1 | round-off of the time | smallest step
step.contact_events.LEFT_BEFORE_ONSET | 1 | time to an onset | part that a step leaves before an unknown impact | 0.1 0.5 5
step.contact_events.NEAR_GAP | 1 | size of the mechanism | gap up to which a step may cross an unknown onset
step.contact_events.LOOKS | 1 | a step | places at which a step is looked at | 0.5 2
step.contact_events.UNEXPECTED_GAP | 1 | gap at an end | difference from the cubic that is too large
run.run.Run.begin#0.001 | 1 | largest step | first step
start.redundant_joints.looks_dependent#10.0 | 1 | HOLD | pivot that seems lost at the start
step.step_size.IMPACT_STEPS | steps | an impact | steps of an impact with rtol = 1e-4 | 0.125 0.25 4 10
step.step_size.FEWEST_IMPACT_STEPS | steps | an impact | fewest steps of an impact, for any rtol | 0.125 4 10
step.step_size.FLIGHT_WEIGHT | 1 | error of positions | how much more it counts in flight
step.step_size.SMOOTH_STEPS | steps | period of the drives | largest step, without clearance
step.step_size.LARGEST_STEPS | steps | period of the drives | largest step, with clearance | 0.04 0.1 10 40
start.assemble.CLOSED_GAP | 1 | size of the mechanism | gap of a loop that is closed
start.assemble.DRIVE_STRIDE | rad | nothing | most that the pose is turned at once at the start
start.assemble.MOST_ITERATIONS | iterations | nothing | most iterations that close the loops | 0.1 10
start.assemble._newton#1000.0 | 1 | CLOSED | gap of a loop that will do
start.assemble.LARGEST_MOVE | rad | nothing | longest correction of the start
linalg.lu.LOST_PIVOT | 1 | largest term of a pivot | pivot that is lost
linalg.lu.HELD_PIVOT | 1 | largest term of a pivot | pivot of a row that may be held
linalg.rank.RANK_TOLERANCE | 1 | rows of unit length | rows that repeat others
start.consistent.MOST_ITERATIONS | iterations | nothing | rounds that friction in joints takes at the start | 0.1 10
start.consistent.rigid_velocities#1e-07 | 1 | largest rate | velocities at the start that contradict one another
""")

ASKED = _numbers("""
Adaptive.rtol | 1 | largest speed of the run | accepted error of velocities in a step
Adaptive.atol | m | rtol times least clearance | accepted error of positions in a step
Adaptive.max | s | period of the drives | largest step | 0.01 0.1 10
Adaptive.min | s | largest step | smallest step | 0.01 100 1e4 1e6
Adaptive.impact_steps | steps | an impact | steps of an impact | 0.1 0.25 4 10
generalised_alpha.radius | 1 | method | spectral radius at infinite frequency | 0.1 0.5 1.25
normal.least_approach | m/s | nothing | a contact that begins slower has no approach speed
ModifiedCoulomb.v0 | m/s | nothing | slip speed below which there is no friction | 0.01 0.1 5
ModifiedCoulomb.v1 | m/s | nothing | slip speed of full friction | 0.2 10 100
""")

FLEXIBLE_TOO = frozenset(
    """
Adaptive.rtol Adaptive.atol Adaptive.max Adaptive.impact_steps generalised_alpha.radius normal.least_approach
ModifiedCoulomb.v0 ModifiedCoulomb.v1
step.newmark.error_control.error_ratio#0.05 step.newmark.error_control.node_error#12.0 step.newmark.redundant_constraints.OPENING_FRACTION step.contact_events.ONSET_TOLERANCE
step.contact_events.PROBE_FRACTION step.contact_events.LONGEST_IMPACT step.contact_events.LEAST_DEPTH step.contact_events.PEAK_ACCELERATION_FACTOR
step.newmark.implicit_step.SMALL_SYSTEM step.newmark.implicit_step.NONLINEAR_CORRECTION step.newmark.newton_correction.ROUND_OFF step.newmark.jacobian_reuse.SLOPE_CHANGE step.newmark.jacobian_reuse.REMAINING_ERROR
step.newmark.jacobian_reuse.NEGLIGIBLE_CORRECTION step.newmark.jacobian_reuse.NEGLIGIBLE_WITH_FRICTION run.run.NEWTON_TOLERANCE
run.step_limits.step_limits#0.01 run.step_limits.step_limits#100.0
linalg.lu.HELD_PIVOT
""".split()
)
"""Numbers that are varied in the run with flexible links too: the others act there as they do in the rigid ones, on the
same contact, and a turn costs seconds."""

ELSEWHERE = _numbers("""
contact.friction.creep.SCANNED | points | speeds of creep | where `creep_speed` looks for a balance
contact.friction.bengisu_akay.BengisuAkay.v0 | m/s | nothing | slip speed of the static peak
contact.friction.bengisu_akay.BengisuAkay.decay | s/m | nothing | how fast friction falls from it
contact.friction.brown_mcphee.BrownMcPhee.transition_speed | m/s | nothing | slip speed of the static peak
contact.friction.lugre.LuGre.stribeck_speed | m/s | nothing | slip speed of the fall to kinetic friction
contact.friction.lugre.LuGre.stiffness | 1/m | nothing | stiffness of bristles over the normal force
contact.friction.smooth_coulomb.SmoothCoulomb.v0 | m/s | nothing | slip speed of 76 % of full friction
contact.friction.stribeck.Stribeck.stribeck_speed | m/s | nothing | slip speed of the fall to kinetic friction
contact.friction.stribeck.Stribeck.v0 | m/s | nothing | slip speed of the rise from rest
contact.friction.threlfall.Threlfall.v0 | m/s | nothing | slip speed of 95 % of full friction
contact.friction.lugre.lugre_kernel#1e-200 | N | nothing | normal force below which bristles are at rest
contact.normal.cylinder.END | 1 | force a length | end of use of the logarithmic laws
contact.normal.cylinder.END_DEPTH | 1 | sigma A | the same as a depth
contact.normal.cylinder.line_load#1e-15 | 1 | logarithm of the force | accuracy of the force of a logarithmic law
contact.normal.hysteresis.MISS | 1 | restitution | what a law may miss without a warning
contact.restitution.SMALL_CHI | 1 | chi | below it a series is summed
contact.restitution.TERMS | terms | nothing | terms of that series
contact.restitution.SERIES_FROM | 1 | restitution | from it on the series serves
contact.validity.WIDE | 1 | radius of the journal | half-width of a contact that gets a remark
contact.validity.SMALL_EXCESS | 1 | largest force | force above a free impact's that goes without a remark
results.remarks.SMALL_SHARE | 1 | impulse, loss | slow contacts that go without a remark
contact.validity.SMALL_TENSION | 1 | largest force | cut tension that goes without a remark
bodies.point_mass.SAME_POINT | 1 | distance from the origin | distance from a particle that is none
bodies.point_mass.NO_MOMENT | 1 | forces of a part | moment on a particle that is round-off
joints.revolute_clearance.TOUCHING | 1 | clearance | round-off of a start that touches
sensitivity.run.LEAST_FADING_GAMMA | 1 | method | gamma below which errors of accelerations stay
sensitivity.run.STATE_DIFFERENCE | 1 | size of the mechanism | differences of states for a derivative
step.runge_kutta.PROJECTIONS | iterations | nothing | projections of a Runge-Kutta step
step.runge_kutta.MOST_REPETITIONS | iterations | nothing | rounds that friction in joints takes there
step.radau.method.LARGEST_GROWTH | 1 | a step | most that a step of Radau's method grows at once
step.radau.method.LEAST_GROWTH | 1 | a step | most that it is shortened at once
step.radau.method.SAFETY | 1 | a step | safety factor of the next step
step.radau.method.LEAST_STEPS | steps | a period or a run | fewest steps of Radau's method without clearance
step.radau.method.LEAST_STEPS_CONTACTS | steps | a period or a run | the same with clearance
step.radau.step.MOST_ITERATIONS | iterations | nothing | most Newton iterations of a step of Radau's method
step.radau.step.REFACTOR_RATE | 1 | a correction | rate of corrections that asks for new factors
step.radau.step.REFACTOR_ITERATIONS | iterations | nothing | iterations that ask for new factors
step.radau.step.ITERATION_FRACTION | 1 | accepted error, rtol^(1/2) | what Newton's iterations leave
step.radau.step.FIXED_STEP_TOLERANCE | 1 | h^2 a | the same for steps of one size
step.radau.step.LEAST_TOLERANCE | 1 | h^2 a | least that is asked for
step.radau.step.CLOSED_SHIFT | 1 | size of the mechanism | shift onto the joints that is round-off
step.radau.step.LARGE_SHIFT | 1 | size of the mechanism | shift that is taken by full projections
step.radau.step.STALLED_RATE | 1 | a correction | ratio of corrections that are round-off
step.radau.works.ACCELERATION_MISMATCH | 1 | accelerations | difference to interpolated ones that shows stiff forces
step.radau.works.INSENSITIVE | 1 | that difference | change by other interpolated positions that shows a kink
step.radau.step.LEAST_RATE | 1 | a correction | rate that a first iteration is trusted with
energy.balance.RESIDUAL_LIMIT_RUNGE_KUTTA | 1 | energy turned over | largest residual of a Runge-Kutta run
step.newmark.redundant_constraints.EFFECT_LIMIT | 1 | largest entry | joints that share a force that is not unique, in the status
results.status.WARNING_FRACTION | 1 | limits of the ledger | from here on the status warns
step.contact_log.ROUND_OFF_GAP | 1 | size of the mechanism | gap at the start that is a contact
sensitivity.tangent_step.MOST_ROUNDS | iterations | nothing | iterations of a carried step
sensitivity.tangent_step.CONVERGED_CHANGE | 1 | carried differences | change that is round-off
sensitivity.tangent_step.DIVERGED_CHANGE | 1 | carried differences | change that has to become smaller
sensitivity.linearise.TIME_DIFFERENCE | 1 | a step | part of it in which a neighbour must touch
sensitivity.linearise.POSE_DIFFERENCE | rad | nothing | turn over which rows of joints are differenced
sensitivity.histories.RELATIVE_DIFFERENCE | 1 | histories | differences for the derivative of a law
sensitivity.histories.LEAST_DIFFERENCE | 1 | histories | least difference
sensitivity.histories.NODE_DIFFERENCE | 1 | gap and rate | differences for the derivative of a law
sensitivity.histories.LEAST_NODE_DIFFERENCE | 1 | a step | how far from an onset
equilibrium.geometric_stiffness.PATH_STRIDE | 1 | size of the mechanism | step of the path for the slope of the stiffness
equilibrium.geometric_stiffness.FLAT | 1 | second moments | points on a line
system.turns.ISOTROPIC | 1 | stiffness | change by a turn of a stiffness without a direction
equilibrium.half_load.TRUSTED | 1 | load factor | difference of the factor from half the load that goes without a note
equilibrium.half_load.SMALL_MOVEMENT | 1 | size, or rad | movement under half the load that goes without a note
equilibrium.half_load.LOAD_STEPS | steps | nothing | load steps to half the load
equilibrium.half_load.MOST_ITERATIONS | iterations | nothing | most iterations of such a step
equilibrium.half_load.FOUND_STEP | 1 | size, or rad | correction of an equilibrium that is found
equilibrium.half_load.LONGEST_STEP | 1 | size, or rad | longest correction
equilibrium.buckling.EIGENVALUE_ROUND_OFF | 1 | largest | factor that counts as none
equilibrium.buckling.ASYMMETRY | 1 | entries | difference that makes loads follow the motion
equilibrium.buckling.MISSED | 1 | a shape | residual of a load factor that is found
equilibrium.eigen.LOOKED_FOR | 1 | an eigenvalue | accuracy with which a lower one is looked for
equilibrium.eigen.DENSE_COORDINATES | unknowns | nothing | up to it matrices are dense
equilibrium.eigen.FEW_MODES_COORDINATES | unknowns | nothing | the same where few modes are asked for
equilibrium.eigen.DENSE_QUADRATIC_COORDINATES | unknowns | nothing | the same with damping
linalg.dense_or_sparse.DENSE_UNKNOWNS | unknowns | nothing | up to it start values are found dense
equilibrium.modes.ENERGY_ROUND_OFF | 1 | frequencies | round-off of a frequency
equilibrium.same_model.OTHER_MODEL_STEP | 1 | a mode | part of another
equilibrium.modes.ASYMMETRY_ROUND_OFF | 1 | entries | round-off of a symmetric matrix
equilibrium.modes.ASYMMETRY_OF_DIFFERENCES | 1 | entries | the same with controllers, whose inputs are differenced
equilibrium.free_motions.DENSE_MOTIONS | motions | nothing | up to it matrices of rigid motions are dense
equilibrium.free_motions.ROW_ROUND_OFF | 1 | terms of a row | entry of a constraint on a body that is round-off
equilibrium.free_motions.DEPENDENT_ROW | 1 | rows | motion that rows allow
equilibrium.free_motions.FREE_FORCE | 1 | stiffness | motion that nothing resists
equilibrium.free_motions.STIFFNESS_ROUND_OFF | 1 | entries | entry of a motion that is round-off
equilibrium.free_motions.SMALL_SHARE | 1 | a motion | part of it that is named
linalg.pivoting.GOOD_RESIDUAL | 1 | right-hand side | residual of a system that was solved
linalg.pivoting.ROUND_OFF | 1 | right-hand side | residual that needs no better
linalg.pivoting.SINGULAR_GROWTH | 1 | right-hand side | solution of a matrix that counts as singular
linalg.pivoting.SCALING_ROUNDS | rounds | nothing | rounds that scale rows and columns
start.assemble.SPARSE_ENTRIES | entries | nothing | up to it loops are closed by a dense least-squares solution
linalg.rank.CERTAIN_INVERSE | 1 | rows of unit length | inverse of G G^T of rows that are independent beyond doubt
system.state_evaluation.LARGE_UNKNOWNS | unknowns | nothing | above it factors are kept for the next matrices
linalg.kept_factors.DIAGONAL_SHARE | 1 | column | pivot on the diagonal that is taken
linalg.kept_factors.EXACT | 1 | terms of an equation | error of a solution by factors of another matrix
linalg.kept_factors.FLOOR | 1 | largest terms | terms of an equation that are none
linalg.kept_factors.MOST_REFINEMENTS | rounds | nothing | refinements by factors of another matrix
linalg.kept_factors.SLOWEST | 1 | error before | refinement that is too slow
linalg.kept_factors.REGULAR | 1 | scaled matrix | inverse of a matrix that is regular beyond doubt
linalg.bordered.JOINT_COMPLIANCE | 1 | stiffness | give of rows that may repeat one another
linalg.bordered.HOLD | 1 | stiffness | stiffness of constraints beside it while signs are counted
linalg.bordered.DENSE_PIVOTS | unknowns | nothing | up to it eigenvalues are counted dense
linalg.ordering.LARGE_GRAPH | blocks | nothing | above it SuperLU orders
equilibrium.eigen.MOST_RESTARTS | restarts | nothing | search for load factors among those without end
equilibrium.statics.STEP_ACCURACY | 1 | Newton's correction | its error in a large model
equilibrium.statics.TANGENT_ACCURACY | 1 | length of a tangent | its error in a large model
bodies.point_mass.MANY_PARTS | parts | nothing | above it compiled kernels tell what turns a particle
controllers.pid.FILTER_RATIO | 1 | kd / kp | filter of the derivative, where none is given
system.controls.RELATIVE_DIFFERENCE | 1 | an input or a state | differences of a control law
system.controls.LEAST_SIZE | 1 | nothing | inputs and states are differenced as if this large
system.controls.COORDINATE_DIFFERENCE | m, rad | nothing | differences of signals that controls read
step.newmark.newton_correction.STATE_ROUND_OFF | 1 | a state of a control | corrections below this part are round-off
step.newmark.newton_correction.LEAST_CORRECTION | 1 | nothing | least tolerance of a state of a control that stays 0
step.newmark.error_control.LEAST_STATE | 1 | nothing | least scale of a state of a control that stays 0
start.consistent.SETTLED | 1 | a state of a control | last correction of states that begin at rest
run.sampling.SETTLED | 1 | a state of a control | the same of sampled controllers
run.sampling.DIFFERENCE | 1 | a state of a control | differences of a sampled law
run.sampling.MOST_ITERATIONS | iterations | nothing | most rounds to states that begin at rest
start.projection.CLOSED_GAP | 1 | size of the mechanism | gap of a projected pose
start.projection.MOST_ITERATIONS | iterations | nothing | most rounds of a projection
bodies.rigid_link.MASSLESS | 1 | smallest mass of other bodies | mass of a massless link
planes.full_body.PIN_SHARE | 1 | mass of the body | mass of an averaged pin, taken from its nodes
start.consistent.ROUND_OFF_OF_RATES | 1 | largest rate of the drives | start velocity that is round-off
start.consistent.RATES | intervals | period of a drive | instants at which its rate is looked at
start.massless.NO_INERTIA | 1 | largest inertia | motion of massless links alone
start.massless.SHARE | 1 | a motion | part of it of a link that is named
start.redundant_joints.POSE_SHIFT | rad | nothing | how far a pose is moved to see which rows repeat others
equilibrium.dynamic_relaxation.MOST_STRIDES | strides | nothing | most strides to a pose at rest
equilibrium.dynamic_relaxation.STRIDE_ITERATIONS | iterations | nothing | most iterations of a stride
equilibrium.dynamic_relaxation.LARGEST_STRIDE | 1 | size, or rad | longest stride
equilibrium.dynamic_relaxation.REST_STRIDE | 1 | size, or rad | stride of a pose at rest
equilibrium.steady_rotation.SPEED_TOLERANCE | 1 | angular speed | bodies that spin alike
equilibrium.stability.STIFFNESS_ASYMMETRY | 1 | stiffness | above it a stiffness has no potential
equilibrium.statics.MOST_ITERATIONS | iterations | nothing | most iterations of an equilibrium
equilibrium.statics.MOST_OF_LONG_STEP | iterations | nothing | the same of a load step that is longer than asked for
equilibrium.statics.STEP_ROUND_OFF | 1 | size, or rad | correction that is round-off
equilibrium.statics.FOLLOWED | 1 | load step | difference from the tangents up to which a load step may be longer than asked for
equilibrium.statics.LONG_LOAD_STEP | 1 | what tangents see | a load step that is longer is halved
equilibrium.statics.SNAP_LOAD_STEP | 1 | what tangents see | the same at the smallest size: refused
equilibrium.statics.CLOSED_GAP | 1 | size of the mechanism | gap of a joint in equilibrium
run.start_at_rest.OTHER_SPEED | 1 | velocities of a steady rotation | velocities that joints and drives share
equilibrium.statics.LEAST_JUMP | 1 | loads | when two equilibria are the same
dynamics.sections.crossing.ROUNDS | iterations | nothing | most rounds to a crossing
dynamics.sections.crossing.HALVINGS | halvings | nothing | most halvings of a step there
dynamics.sections.crossing.CLOSE | 1 | a step | how near a crossing has to be
dynamics.verdict.cycles.RETURNS | returns | nothing | returns that make a cycle
dynamics.verdict.cycles.TAIL | points | nothing | least points of a cycle
dynamics.verdict.cycles.LONGEST | points | nothing | longest cycle that is looked for
dynamics.exponents.second_run.PART | 1 | points of the first run | the second run has one in so many
dynamics.exponents.second_run.SETTLES | 1 | points of the first run | the second run leaves out one in so many
dynamics.exponents.second_run.LEAST | points | nothing | points of the second run, at least
dynamics.exponents.second_run.APART | 1 | size of the state | distance of the other start
dynamics.verdict.bands.LEAST_IN_BAND | points | nothing | points of a band that doubles
dynamics.verdict.bands.FINER | 1 | mean square | what a doubling leaves at most
dynamics.verdict.bands.FEWEST_DOUBLINGS | doublings | nothing | fewest that accumulate
dynamics.verdict.stationarity.BLOCKS | blocks | nothing | parts of a record that are laid on a line
dynamics.verdict.stationarity.LEAST_BLOCKS | blocks | nothing | fewest of them
dynamics.verdict.stationarity.LEAST_OF_BLOCK | points | nothing | points of one
dynamics.verdict.stationarity.STRAIGHT | 1 | mean square | share of the line in a drift
dynamics.verdict.stationarity.LEAST_IN_BAND | points | nothing | points of a band whose mean is taken away
dynamics.exponents.exponent_error.BLOCKS | blocks | nothing | blocks that an error is taken from
dynamics.exponents.exponent_error.FEWEST_BLOCKS | blocks | nothing | fewest of them
dynamics.exponents.exponent_error.POWER | 1 | logarithm of time | growth like this power of time is none
dynamics.exponents.exponent_error.LOGS | 1 | round-off | error of a logarithm
dynamics.exponents.exponent_error.WITHIN | 1 | errors | exponents that do not differ
dynamics.exponents.exponents.CLEARLY | 1 | errors | a second exponent that speaks against a regular motion
dynamics.exponents.exponents.FEWEST | intervals | nothing | fewest for an error
dynamics.exponents.exponents.SETTLING | intervals | nothing | those that directions need to settle
dynamics.orbits.floquet.REAL | 1 | a multiplier | imaginary part that is none
dynamics.orbits.floquet.NEAR | 1 | a multiplier | distance from 1 that names a bifurcation
dynamics.orbits.continuation.SHARPEST | 1 | cosine | sharpest turn of a branch between points
dynamics.orbits.continuation.FEW | iterations | nothing | a step grows below
dynamics.orbits.continuation.MANY | iterations | nothing | a step shrinks above
dynamics.orbits.continuation.CORRECTIONS | iterations | nothing | most corrections of a point
dynamics.orbits.continuation_point.LOCATED | 1 | a step of a branch | accuracy of a bifurcation
dynamics.orbits.grazing.SAMPLES | points | period | where a grazing is looked for
dynamics.orbits.grazing.FINER | points | a sample | the same, near it
dynamics.orbits.grazing.SHARP | 1 | a multiplier | change that shows a grazing
dynamics.systems.impact_ode.PILE | 1 | interval | impacts that are closer pile up
dynamics.exponents.benettin.APART | 1 | size of the state | distance of a companion
dynamics.exponents.benettin.APART_IN_CONTACT | 1 | size of the state | the same with contacts
dynamics.exponents.schedule.INTERVALS | intervals | nothing | intervals in which directions are made apart
dynamics.systems.mechanism_flow.SHORTEST | spacings | time | shortest interval
dynamics.systems.mechanism_flow.INSTANT | 1 | period | instants at which rates are compared
dynamics.systems.mechanism_flow.NUDGE | 1 | size of the state | difference for a rate
dynamics.orbits.orbit_newton.HALVINGS | halvings | nothing | most halvings of a correction
dynamics.orbits.orbit_newton.SMALLEST_SINGULAR | 1 | largest singular value | directions without a say
dynamics.orbits.orbit_newton.LARGEST_STRETCH | 1 | size of the state | longest correction
dynamics.systems.ode.FINEST | 1 | state | finest tolerance of a second run
dynamics.systems.ode.TANGENT_ATOL | 1 | tangents | absolute tolerance of carried differences
dynamics.orbits.periodic_orbit.TOLERANCE | 1 | size of the state | what does not come back
dynamics.orbits.periodic_orbit.TOLERANCE_OF_STEPS | 1 | size of the state | the same with error-controlled steps
dynamics.orbits.periodic_orbit.AMPLIFIED | 1 | tolerance | what a multiplier may make of it
dynamics.orbits.periodic_orbit.AT_REST | 1 | size of the state | an orbit that stands still
dynamics.exponents.renormalisation.TOO_MUCH | 1 | a difference | growth that asks for shorter intervals
dynamics.exponents.renormalisation.FAR_TOO_MUCH | 1 | a difference | growth that is repeated
dynamics.exponents.renormalisation.LOST | 1 | largest direction | direction that is lost
dynamics.exponents.schedule.MOST_LOOKS | looks | an interval | most looks
dynamics.sections.section_map.PERIODS | periods | period | longest way to a section
dynamics.sections.section_map.PACES | paces | first pace | the same without a period
dynamics.sections.section_map.AHEAD | 1 | a step | distance from a section that has been left
dynamics.verdict.columns.GROUP | 1 | spread | signals that move together
dynamics.verdict.columns.SEPARATE | 1 | noise | signals that differ
dynamics.verdict.bands.SUCCESSORS | steps | nothing | successors of neighbours
dynamics.verdict.bands.LEAST_WAY | 1 | logarithm of a distance | least growth that counts
dynamics.orbits.shooting.SMALL | 1 | size of the state | differences for derivatives of maps
dynamics.orbits.shooting.SMALL_OF_A_FLOW | 1 | size of the state | the same for flows
dynamics.verdict.verdict.LEAST | points | nothing | least points of a verdict
dynamics.verdict.verdict.LEAST_APERIODIC | points | nothing | the same, of no period
dynamics.verdict.verdict.LEAST_CHAOTIC | points | nothing | the same, of chaos
dynamics.verdict.verdict.CLEARLY | 1 | standard errors | an exponent that is not zero
dynamics.verdict.verdict.SETTLED | 1 | spread | drift of what has settled
dynamics.verdict.verdict.MOST_SIGNALS | signals | nothing | signals that are tested
dynamics.verdict.verdict.PART | 1 | record | lags of the 0-1 test: one over this part
dynamics.verdict.verdict.RELATIVE | 1 | spread | points that are the same
dynamics.basins.attractors.KEPT | points | nothing | points that are remembered
dynamics.basins.attractors.CLOSE | 1 | tolerance | points that may be the same
dynamics.basins.attractors.SAME | 1 | size of the state | points that are the same
series.correlation.LEAST | points | nothing | least points
series.correlation.PERIODS | periods | nothing | least periods
series.correlation.REFERENCES | points | nothing | reference points
series.correlation.PER_E | radii | factor e | radii
series.correlation.SPAN | 1 | logarithm of a radius | least length of a straight part
series.correlation.EVEN | 1 | slope | what is straight
series.embedding.LEAST | points | nothing | least points
series.embedding.FALSE_SHARE | 1 | neighbours | false ones that may be left
series.exponent.LEAST | points | nothing | least points
series.exponent.PERIODS | periods | nothing | least periods
series.exponent.BLOCKS | blocks | nothing | blocks that an error is taken from
series.exponent.MARGIN | 1 | logarithm of a distance | end of a straight part
series.exponent.LEAST_RISE | 1 | logarithm of a distance | least rise
series.exponent.FINITE | 1 | distances | those that are not small any more
series.exponent.FLOW | 1 | logarithm of a distance | a flow, not a map
series.kantz.REFERENCES | points | nothing | reference points
series.kantz.NEIGHBOURS | points | nothing | neighbours of each
series.rosenstein.REFERENCES | points | nothing | reference points
series.samples.LARGEST | 1 | nothing | largest sample whose square is a number
series.samples.ROUND_OFF | 1 | spacing | uneven spacing
series.spectrum.LOBE | bins | nothing | half-width of a line
series.spectrum.ABOVE_FLOOR | 1 | median | height of a line
series.spectrum.AROUND | bins | nothing | width of the median
series.spectrum.LINES | 1 | power | power in lines of what is periodic
series.spectrum.BROAD | 1 | power | the same of what is broad
series.wolf.CANDIDATES | points | nothing | neighbours that are looked at
series.wolf.BIAS | 1 | exponent | bias that is accepted
series.wolf.LASTING | 1 | neighbours | those that last
series.wolf.SMALLEST | 1 | spread | smallest distance
series.zero_one.ENOUGH | points | nothing | least points
series.zero_one.REGULAR | 1 | 0-1 test | regular below
series.zero_one.CHAOTIC | 1 | 0-1 test | chaotic above
linalg.symbolic.WIDEST_PANEL | unknowns | nothing | widest supernode
linalg.symbolic.PANEL_ZEROS | 1 | entries | zeros that supernodes may hold
beams.mesh.SAME_PLACE | 1 | size of the mesh | nodes at one place
beams.mesh.STRAIGHT | rad | nothing | bend of a link that is straight
beams.mesh.FARTHEST | m | nothing | largest coordinate of a mesh
planes.mesh.ON_CIRCLE | 1 | radius | nodes on a circle
planes.mesh.PLACES | digits | size of the mesh | decimal places of the centre of a hole
planes.mesh_checks.SAME_PLACE | 1 | size of the mesh | nodes at one place
planes.mesh_checks.FLAT | 1 | longest side squared | Jacobian determinant of a flat cell
planes.mesh_checks.ON_EDGE | 1 | edge | node on the edge of another cell
planes.blocks.SAME_PLACE | 1 | size of the mesh | nodes of two blocks at one place
planes.blocks.MOST_NODES | nodes | nothing | largest block of a mesh
planes.triangles.CLEAR | 1 | size of the cells | distance of a plate's lattice from the boundary
planes.triangles.ROUNDS | rounds | nothing | rounds of smoothing
planes.triangles.FLAT | 1 | median area | triangle that is round-off
planes.triangles.FEWEST | nodes | nothing | least nodes of a hole
planes.outlines.NARROW | rad | nothing | widest shank whose eye ends on an arc
planes.outlines.LARGEST_TURN | rad | nothing | turn of a fillet along one cell
planes.outlines.NO_CORNER | 1 | radius | shank that leaves an eye without a corner
planes.fillets.FEWEST_ON_ARC | edges | nothing | least edges of a fillet
planes.fillets.SAME_PLACE | 1 | longest edge | ends of two fillets at one place
planes.fillets.STRAIGHT | rad | nothing | corner that is none
planes.triangles.STRETCHED | 1 | two sides | triangle that is flat on an arc
planes.interfaces.NO_ARM | 1 | size of the mesh | nodes at the point of a pin
planes.plane_body.SAME_LENGTH | 1 | length | distance of pins that fits the mesh, point of a joint that is a pin
planes.vibrations.SHIFT | 1 | longitudinal wave squared | shift of the eigenvalues
reduction.accuracy.SHIFT | 1 | lowest reduced frequency squared | shift of the eigenvalues
""")


def _left_out() -> dict[str, str]:
    """Why, by place."""
    reasons = """
    the default of an argument that is varied: contact.onset.LEAST_APPROACH step.step_size.RTOL
    a factor of a formula: dynamics.exponents.exponent_error.LATE contact.friction.lugre.PASSIVE
        energy.contact_work.GAUSS_POINT
        start.projection.WHOLE_TURN
        dynamics.verdict.columns.TURN dynamics.orbits.state_space.TURN beams.chord.TURN
        beams.chord.REST beams.shear.BOW step.saved_instants.PAST_OF_QUADRATIC
    printed with the theory, and only a remark: contact.validity.LOVE contact.validity.YIELD_OF_POINT
        contact.validity.YIELD_OF_LINE
    start values of histories: contact.onset.HISTORY contact.validity.HISTORY_WITH_EXTREMES
    a name of a code, a mode or a place in an array: equilibrium.geometric_stiffness.ENDS system.turns.COORDINATES
        run.interruption.KEYBOARD run.interruption.TERMINATION run.checkpoint.END_COLUMN
        state.record.ENERGY_MISSING state.record.ENERGY_MADE
        state.record.ENERGY_LOST state.record.CONDITION_MET state.flow.EPISODE_SIZE state.flow.EPISODE_ROW_SIZE
        state.flow.IMPACT_SIZE state.flow.CONTACT_MEMORY_SIZE
        results.contact_intervals.IMPACT
        results.contact_intervals.CONTINUOUS
        results.netcdf.FORMAT results.netcdf.SINGLE
        step.newmark.implicit_step.CONTINUE step.newmark.implicit_step.EVALUATE_AGAIN
        run.run.NOT_SAVING sensitivity.tangent_step.TANGENT_LOST
        step.contact_log.IMPACT step.contact_log.LASTING
        results.remarks.APPROACH_PLACE step.contact_log.CLOSING_PHASE step.contact_log.LASTING_PHASE
        linalg.lu.ROWS_HELD linalg.lu.NO_ROW dynamics.sections.crossing.DOWN dynamics.sections.crossing.UP
        dynamics.systems.mechanism_scales.ONSET dynamics.basins.attractors.LOST
        dynamics.basins.attractors.UNDECIDED
        program.signals.CONTACT_PENETRATION program.tables.CONTACT_COMMON beams.peak_stress.SIZE
        program.tables.NO_FACTOR program.tables.FIRST_OUTPUT system.outputs.FRICTION_ALONE
    decides a remark or a refusal, and no number of a run: run.watch.DEEP run.watch.THROUGH run.watch.LEAST_STEPS run.watch.SHARE
        run.watch.LARGE_STRAIN run.watch.IMPOSSIBLE_STRAIN couplings.one_way_clutch.LARGE_WIND_UP cams.curve_on_curve.PULL couplings.cable.LARGE_STRETCH
        couplings.belt.LARGE_STRETCH couplings.gear.LARGE_PLAY couplings.rack.PARTED doctor.coarse_cells.TOO_STIFF results.fatigue.CAPTURED
        run.strength.LEAST
        run.basis_edge.AT_EDGE run.basis_edge.LEFT_OUT run.basis_edge.EDGE_SHARE run.basis_edge.STEP_ERROR reduction.craig_bampton.LEAST_PIVOT reduction.craig_bampton.LEAST_SHARE
        reduction.accuracy.EXACT
        run.deformations.LARGE_SHARE run.deformations.IMPOSSIBLE_SHARE run.deformations.MOST_POINTS
        state.poses.MOST_POSES state.poses.LEAST_POSES state.poses.POSE_NUMBERS
        run.vibrations.MOST_UNKNOWNS run.vibrations.FEWEST_STEPS run.vibrations.MOST_CONTROLLED run.vibrations.POSES run.vibrations.POSES_OF_LARGE
        run.vibrations.AROUND run.vibrations.DISTANCE run.vibrations.LARGE run.vibrations.MANY run.vibrations.AROUND_OF_MANY run.vibrations.FEWEST_STATES run.vibrations.SAME
        equilibrium.vibrations.RIGID_OF_LARGE equilibrium.vibrations.DENSE equilibrium.vibrations.LOWEST
        run.vibrations.FEWEST_INSTANTS equilibrium.vibrations.NEAR equilibrium.vibrations.RIGID equilibrium.vibrations.ROUND_OFF run.vibrations.ENERGY_SHARE run.vibrations.DECAY
        run.vibrations.PART_OF_STEP run.vibrations.UNRESOLVED
        run.vibrations.LOST_PHASE run.vibrations.LOST_AMPLITUDE run.checkpoint.EVERY results.netcdf_content.LARGEST_GROWTH
        run.failure.STEP_CODES run.failure.SHOWN_RESIDUALS run.failure.LEAST_RESIDUAL run.failure.LEAST_RTOL run.failure.TRIED_STEPS
        system.failed_kernels.MOST_CALLS system.failed_kernels.SHOWN_NUMBERS
        linalg.rank.DENSE_ROWS linalg.rank.IN_COMBINATION equilibrium.eigen.LONGEST_SEARCH
        equilibrium.dynamic_relaxation.INDEPENDENCE
        equilibrium.dynamic_relaxation.ROUND_OFF linalg.null_vector.DENSE_COLUMNS linalg.null_vector.FIRST_VECTORS linalg.null_vector.VANISHING linalg.null_vector.REGULARISATION
        linalg.null_vector.LEAST_PIVOT linalg.null_vector.ITERATIONS run.stopping.SAME run.stopping.LEAST run.stopping.MOST_TRIALS
        run.lost_control.TIMES_TARGET controllers.pid.JUST_BEFORE controllers.pid.LATEST_BREAK controllers.pid.TARGETS
        run.save_grid.SAME_TIME run.step_limits.LEAST_SEEN run.step_limits.LEAST_CLEAR
    round-off of a time, from which a saved instant is the end of its step: step.saved_instants.END_OF_STEP run.save_grid.SAME_INSTANT
    refuses what would take too long: controllers.control.LEAST_SAMPLE
    squares of smaller numbers are 0 among floats: run.simulate.SHORTEST_RUN
    stands for infinity: state.options.NEVER
    stands for a clearance that does not exist: joints.stop.NO_CLEARANCE
    a size of a buffer, a block or a store: reduction.shared.REMEMBERED state.flow.PAST_STATES run.run.BUFFER_ROWS
        run.run.BLOCK_SECONDS run.run.FIRST_BLOCK_UPDATES dynamics.basins.basin.CHUNKS series.neighbours.BLOCK
        series.recurrence.BLOCK program.check_kernels.REMEMBERED_CALLS program.structure.REMEMBERED_STRUCTURES
        program.structure.REMEMBERED_UNKNOWNS program.structure.FIELDWISE_FROM run.run.BUFFER_NUMBERS run.run.LEAST_BUFFER_ROWS
        run.saved_rows.MOST_RESERVED_BYTES results.late_values.BLOCK
    size of a symbol in a picture: results.symbols.COILS results.symbols.WIDTH results.symbols.ARROW results.symbols.HEAD loads.mesh_load.ARROWS loads.mesh_load.NO_ARROW
        results.symbols.CIRCLE_POINTS results.symbols.ARC_POINTS results.symbols.OVERHANG
    how many are printed or written: results.netcdf_nodes.MOST_SINGLE results.main_signals.MOST results.solution_text.MOST_OF_A_KIND results.main_signals.PANELS start.consistent.LISTED_PARTS results.vtk.MOST_FRAMES results.contact_intervals.SHOWN_ROWS
        model.signal.MOST_COMPARED_NAMES results.solution_text.IN_TEXT results.solution_text.IN_TABLE results.solution_text.ROUND_OFF
        equilibrium.modes.SHOWN_MODES dynamics.exponents.exponents.SHOWN
    shortens what another number decides: linalg.rank.CERTAIN_EIGENVALUE
    coefficients and stages of Radau's method, exact: step.radau.collocation.C step.radau.collocation.ESTIMATE
        step.radau.collocation.FROM_IM step.radau.collocation.FROM_RE step.radau.collocation.FROM_REAL
        step.radau.collocation.LAST step.radau.collocation.MIDDLE step.radau.collocation.ONCE
        step.radau.collocation.PAIR_IM step.radau.collocation.PAIR_RE step.radau.collocation.REAL
        step.radau.collocation.STAGES step.radau.collocation.TO_IM step.radau.collocation.TO_RE
        step.radau.collocation.TO_REAL step.radau.collocation.TWICE step.radau.collocation.WEIGHTS
        step.radau.collocation._ROOT
    exact for what it integrates, or arbitrary instants: beams.fem.QUADRATURE_ORDER dynamics.systems.ode.INSTANTS
    """
    found, reason = {}, ""
    for word in reasons.split("\n"):
        head, colon, rest = word.partition(": ")
        reason = head.strip() if colon else reason
        found |= dict.fromkeys((rest if colon else head).split(), reason)
    return found


LEFT_OUT = _left_out()
"""Reason by place; names that are unpacked from a range are enumerations, and left out without being listed."""
