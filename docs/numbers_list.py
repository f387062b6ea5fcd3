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
parts.contact.onset.crossing#40 | iterations | nothing | most iterations for the instant of an onset | 0.05 0.1 10
parts.contact.onset.crossing#1e-15 | 1 | a step | accuracy of the instant of an onset | 0.01 0.1 10 100 1e6
engine.newmark.error_control.CONTACT_TRIALS | trials | nothing | most trials of one step that look for a contact | 0.125 0.5 10
engine.newmark.error_control.ERROR_ACROSS_JUMP | 1 | accepted error | error of velocities in a step across a jump of a control law | 0.1 0.5 2 10
engine.newmark.error_control.BISECTIONS | bisections | nothing | part of a step down to which a change of a control law must last to be a jump | 0.8 1.2
engine.newmark.error_control.MOST_JUMPS | jumps | nothing | number of near jumps of a control law above which it slides along its jump | 0.5 2
engine.newmark.error_control.SLIDING_TIME | 1 | step of the error estimate | time in which jumps of a control law are near to one another | 0.1 10
engine.newmark.error_control.LASTING_SHARE | 1 | change of a law in a step | share of the change that must last | 0.2 0.5 2 5
engine.newmark.error_control.LEAST_JUMP | 1 | largest output so far | least jump of an output | 1e-3 0.1 10 1000
engine.newmark.error_control.UNCHANGED_FROM | 1 | a step | a step is not shortened for less | 0.1 0.5 1.05
engine.newmark.error_control.UNCHANGED_TO | 1 | a step | a step is not lengthened for less | 0.84 1.25 1.6
engine.newmark.error_control.velocity_constant#0.02 | 1 | method | floor of the error constant of velocities
engine.newmark.error_control.error_ratio#0.05 | 1 | method | floor of the error constant of positions
engine.newmark.error_control.node_error#12.0 | 1 | method | error of a first step: change of the acceleration over this
engine.newmark.error_control.SAFETY | 1 | a step | safety factor of the next step | 0.1 0.5 1.1
engine.newmark.method.LEAST_GROWTH | 1 | a step | most that a step is shortened at once | 0.1 0.5 2
engine.newmark.method.LARGEST_GROWTH | 1 | a step | most that a step grows at once | 0.6 2 10
engine.newmark.error_control.meets_contacts#0.25 | 1 | a step | what becomes of a step that did not converge | 0.1 0.5 2
engine.newmark.jacobian_reuse.CLOSED_GAP | 1 | size of the mechanism | gap of a row that may be held
engine.newmark.jacobian_reuse.OPENING_FRACTION | 1 | way h^2 a | gap of a row that may be held in the first steps
engine.newmark.jacobian_reuse.HOLD_WITHIN_STEP | 1 | largest term of a pivot | with what rows are held within a step that holds some
engine.newmark.jacobian_reuse.PASSING_STEPS | steps | nothing | steps that pass a singular position | 0.34 10 100
engine.newmark.jacobian_reuse.allowed_gap#0.01 | 1 | size of the mechanism | cap of that way
engine.step.contact_events.ONSET_TOLERANCE | 1 | step of an impact | a contact begins, or has ended, within this part of it
engine.step.contact_events.PROBE_FRACTION | 1 | duration of an impact | first trial of an impact
engine.step.contact_events.JUMP_STEP_FRACTION | 1 | step of an impact | step just into a contact whose force jumps
engine.step.contact_events.DURATION_FACTOR | 1 | depth / approach speed | estimate of the duration of an impact | 0.1 0.5 2 10
engine.step.contact_events.LEAST_DURATION_FACTOR | 1 | depth / approach speed | least duration of a first impact | 0.1 0.5 2
engine.step.contact_events.PEAK_ACCELERATION_FACTOR | 1 | approach speed / duration | estimate of the largest acceleration | 0.1 0.5 2 10
engine.step.contact_events.SHORTEN_BELOW | 1 | step of an impact | a step is changed within an impact below this | 0.01 0.1 1.2
engine.step.contact_events.LENGTHEN_ABOVE | 1 | step of an impact | a step is changed within an impact above this | 0.65 10 100
engine.step.contact_events.LONGEST_IMPACT | 1 | estimated duration | an impact that takes longer is left to the error
engine.step.contact_events.LEAST_DEPTH | 1 | size of the mechanism | a dip of a gap below zero that may be round-off
engine.step.contact_events.find_force_jump#0.001 | 1 | depth of a step | depth at which a jump of the force is looked for
engine.step.contact_events.find_force_jump#0.1 | 1 | force of a step | smallest force there that is a jump | 0.01 0.1 9
engine.step.contact_events.step_to_events#1.3 | 1 | steepest change | an impact's step that changes more is refused | 0.1 0.5 10 100
engine.step.contact_events.step_to_events#0.2 | 1 | a step | most that a step within an impact is shortened at once | 0.1 0.5 4
engine.step.contact_events.impact_step#0.5 | 1 | approach speed | rate from which a trial has rebounded | 0.1 0.5 2 10
engine.step.contact_events.impact_step#0.001 | 1 | energy of an approach | least part of it that an impact took
engine.step.contact_events.impact_duration#0.5 | 1 | duration of an impact | what forces of flight make of it | 0.01 0.1 10
engine.step.contact_events.update_impacts#0.4 | 1 | energy of an approach | left of it when the step is checked | 0.01 0.1 2
engine.step.contact_events.update_impacts#0.9 | 1 | energy of an approach | left of it when the step is checked | 0.5 1.1
engine.energy.RESIDUAL_LIMIT | 1 | energy turned over | largest residual of a run that is ok
engine.energy.ALGORITHM_LIMIT | 1 | energy turned over | largest energy that the steps take or make
engine.energy.CONTACT_LIMIT | 1 | energy through contacts | largest energy that the steps take or make there
engine.energy.LEAST_CONTACT_FRACTION | 1 | energy turned over | from here on contacts are judged
engine.energy.UNCHANGED | 1 | kinetic energy of a group of bodies | change up to which it had no part in the motion
engine.energy.COORDINATE_ROUND_OFF | 1 | coordinates | round-off of a coordinate
engine.energy.LEAST_RATE_POWER | 1 | power of dampers | part of it from which differences of rates count
engine.energy.LEAST_ENERGY | J | nothing | energy below which its parts lack digits
engine.energy.STEPS_BEFORE_CHECK | steps | nothing | steps before the first verdict on energies
engine.energy.energy_scale#1e-06 | 1 | energy of heights | part of it that counts as turned over
engine.energy.energy_supplied#1e-06 | 1 | energy of heights | part of it that counts as put in
engine.newmark.implicit_step.ROUND_OFF | 1 | coordinates | corrections below this part are round-off
engine.newmark.jacobian_reuse.SMALL_SYSTEM | unknowns | nothing | up to so many, each iteration that rubs has its own matrix
engine.newmark.implicit_step.NONLINEAR_CORRECTION | 1 | what is wanted | size of a correction up to which its factors serve a contact
engine.newmark.implicit_step.GAP_ROUND_OFF | 1 | round-off of corrections | round-off of a gap
engine.newmark.implicit_step.FORCE_ROUND_OFF | 1 | round-off of coordinates | round-off of forces, of a correction that stalls
engine.newmark.implicit_step.ANGLE_ALLOWANCE | rad | nothing | angles up to here have the round-off of 1 rad
engine.newmark.implicit_step.FAR_ALLOWANCE | 1 | lengths from the origin | round-off of angles in mechanisms that are far away
engine.newmark.implicit_step.ROUND_OFF_FRACTION | 1 | corrections | noise, and a correction that does not get smaller | 0.01 0.1 5
program.numbering.ONE_PLACE | 1 | distance from the origin | extent of nodes that lie in one place
engine.newmark.predictor.FARTHEST_LEAP | 1 | shortest beam or mechanism, or rad | way by predicted accelerations that is no start
engine.newmark.predictor.OLD_ERROR_WEIGHT | 1 | what an order missed | weight of what was before the last step | 0.01 0.1 1.9
engine.newmark.jacobian_reuse.LONGEST_SUSPENSION | steps | nothing | most steps with new factors after old ones were refused
engine.newmark.jacobian_reuse.OLDEST_FACTORS | steps | nothing | factors that served so many go
engine.newmark.jacobian_reuse.MOST_EXTRA_ITERATIONS | iterations | nothing | factors that cost so many go
engine.newmark.jacobian_reuse.COEFFICIENT_CHANGE | 1 | coefficients of a step | factors whose coefficients differ more go | 0.01 0.1 4
engine.newmark.jacobian_reuse.REGULAR_PIVOT | 1 | largest term of a pivot | pivot with which factors may serve again
engine.newmark.jacobian_reuse.MEASURING_INTERVAL | steps | nothing | steps after which theta is measured anew
engine.newmark.jacobian_reuse.GOOD_CONTRACTION | 1 | corrections | theta with which one correction is believed | 0.01 0.1 9
engine.newmark.jacobian_reuse.FAIR_CONTRACTION | 1 | corrections | theta with which iterations go on | 0.01 0.1 3
engine.newmark.jacobian_reuse.SLOPE_CHANGE | 1 | slope of a law | largest change of a slope with the same factors | 0.01 0.1 1.9
engine.newmark.jacobian_reuse.CORRECTION_GROWTH | 1 | first correction before | one that is larger is not believed alone
engine.newmark.jacobian_reuse.MOST_REUSE_ITERATIONS | iterations | nothing | most iterations with old factors | 0.25 10 100
engine.newmark.jacobian_reuse.REMAINING_ERROR | 1 | what is wanted | error that a step may be left with
engine.newmark.jacobian_reuse.REMAINING_ROUND_OFF | 1 | round-off | the same where round-off is more
engine.newmark.jacobian_reuse.NEGLIGIBLE_CORRECTION | 1 | what is wanted | last correction after which forces are not evaluated again
engine.newmark.jacobian_reuse.NEGLIGIBLE_WITH_FRICTION | 1 | what is wanted | the same where a contact is closed
engine.newmark.jacobian_reuse.convergence_test#0.001 | 1 | what is wanted | a first correction below it has not grown
engine.newmark.jacobian_reuse.convergence_test#0.05 | 1 | what is wanted | below it, theta cannot be told from round-off
run.run.LARGEST_ROUND_OFF | 1 | size of the mechanism | round-off of coordinates that have no digits left
run.run.NEWTON_TOLERANCE | 1 | way h^2 a | what is wanted of corrections
run.run.NEWTON_ITERATIONS | iterations | nothing | most iterations of Newton's method | 0.1 0.5 10
run.run.step_limits#0.001 | 1 | size of the mechanism | error of positions over rtol, without clearance
run.run.step_limits#0.01 | 1 | size / largest step | least speed for rtol; cap of the clearance for atol
run.run.step_limits#100.0 | 1 | least clearance | way that the least speed for rtol crosses
run.run.step_limits#1e-09 | 1 | largest step | smallest step
run.run.LEAST_STEP | 1 | round-off of the time | smallest step
engine.step.contact_events.LEFT_BEFORE_ONSET | 1 | time to an onset | part that a step leaves before an unknown impact | 0.1 0.5 5
engine.step.contact_events.NEAR_GAP | 1 | size of the mechanism | gap up to which a step may cross an unknown onset
engine.step.contact_events.LOOKS | 1 | a step | places at which a step is looked at | 0.5 2
engine.step.contact_events.UNEXPECTED_GAP | 1 | gap at an end | difference from the cubic that is too large
statics.start.consistent.looks_dependent#10.0 | 1 | HOLD | pivot that seems lost at the start
engine.step.step_size.IMPACT_STEPS | steps | an impact | steps of an impact with rtol = 1e-4 | 0.125 0.25 4 10
engine.step.step_size.FEWEST_IMPACT_STEPS | steps | an impact | fewest steps of an impact, for any rtol | 0.125 4 10
engine.step.step_size.FLIGHT_WEIGHT | 1 | error of positions | how much more it counts in flight
engine.step.step_size.FIRST_STEP | 1 | largest step | first step of a run
engine.step.step_size.SHORT_STEP | 1 | fixed step | fixed step behind which a starting step follows
engine.step.step_size.SMOOTH_STEPS | steps | period of the drives | largest step, without clearance
engine.step.step_size.LARGEST_STEPS | steps | period of the drives | largest step, with clearance | 0.04 0.1 10 40
statics.start.consistent.CLOSED_LOOP | 1 | size of the mechanism | gap of a loop that is closed
statics.start.consistent.DRIVE_STRIDE | rad | nothing | most that the pose is turned at once at the start
statics.start.consistent.MOST_ITERATIONS | iterations | nothing | most iterations that close the loops | 0.1 10
statics.start.consistent._newton#1000.0 | 1 | CLOSED | gap of a loop that will do
statics.start.consistent.LARGEST_MOVE | rad | nothing | longest correction of the start
engine.linalg.lu.LOST_PIVOT | 1 | largest term of a pivot | pivot that is lost
engine.linalg.lu.HELD_PIVOT | 1 | largest term of a pivot | pivot of a row that may be held
engine.linalg.rank.RANK_TOLERANCE | 1 | rows of unit length | rows that repeat others
statics.start.consistent.MOST_FRICTION_ITERATIONS | iterations | nothing | rounds that friction in joints takes at the start | 0.1 10
statics.start.consistent.rigid_velocities#1e-07 | 1 | largest rate | velocities at the start that contradict one another
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
engine.newmark.error_control.error_ratio#0.05 engine.newmark.error_control.node_error#12.0 engine.newmark.jacobian_reuse.OPENING_FRACTION engine.step.contact_events.ONSET_TOLERANCE
engine.step.contact_events.PROBE_FRACTION engine.step.contact_events.LONGEST_IMPACT engine.step.contact_events.LEAST_DEPTH engine.step.contact_events.PEAK_ACCELERATION_FACTOR
engine.newmark.jacobian_reuse.SMALL_SYSTEM engine.newmark.implicit_step.NONLINEAR_CORRECTION engine.newmark.implicit_step.ROUND_OFF engine.newmark.jacobian_reuse.SLOPE_CHANGE engine.newmark.jacobian_reuse.REMAINING_ERROR
engine.newmark.jacobian_reuse.NEGLIGIBLE_CORRECTION engine.newmark.jacobian_reuse.NEGLIGIBLE_WITH_FRICTION run.run.NEWTON_TOLERANCE
run.run.step_limits#0.01 run.run.step_limits#100.0
engine.linalg.lu.HELD_PIVOT
""".split()
)
"""Numbers that are varied in the run with flexible links too: the others act there as they do in the rigid ones, on the
same contact, and a turn costs seconds."""

ELSEWHERE = _numbers("""
engine.newmark.jacobian_reuse.SINGULAR_PIVOT | 1 | largest term of a pivot | near a singular position gaps of redundant rows are not looked at
engine.newmark.jacobian_reuse.ENDLESS_PIVOT | 1 | nothing | pivot of a redundant row
parts.contact.friction.SCANNED | points | speeds of creep | where `creep_speed` looks for a balance
parts.contact.friction.BengisuAkay.v0 | m/s | nothing | slip speed of the static peak
parts.contact.friction.BengisuAkay.decay | s/m | nothing | how fast friction falls from it
parts.contact.friction.BrownMcPhee.transition_speed | m/s | nothing | slip speed of the static peak
parts.contact.friction.LuGre.stribeck_speed | m/s | nothing | slip speed of the fall to kinetic friction
parts.contact.friction.LuGre.stiffness | N/m | nothing | stiffness of all bristles together
parts.contact.friction.SmoothCoulomb.v0 | m/s | nothing | slip speed of 76 % of full friction
parts.contact.friction.Stribeck.stribeck_speed | m/s | nothing | slip speed of the fall to kinetic friction
parts.contact.friction.Stribeck.v0 | m/s | nothing | slip speed of the rise from rest
parts.contact.friction.Threlfall.v0 | m/s | nothing | slip speed of 95 % of full friction
parts.contact.friction.SHORT_DECAY | 1 | nothing | slip in a step over the length of bristles, below which their weight is a series
parts.contact.friction.lugre_kernel#1e-200 | N | nothing | normal force below which bristles are at rest
parts.contact.cylinder_laws.END | 1 | force a length | end of use of the logarithmic laws
parts.contact.cylinder_laws.END_DEPTH | 1 | sigma A | the same as a depth
parts.contact.cylinder_laws.line_load#1e-15 | 1 | logarithm of the force | accuracy of the force of a logarithmic law
parts.bearings.kernels.KEPT | 1 | height of the roughness | film between surfaces that are pressed into each other
parts.bearings.film.SAMPLES | places | nothing | where the largest pressure of a film is looked for
parts.bearings.film.REFINED | iterations | nothing | refinements of the best of them
parts.bearings.film.CELLS | cells | nothing | finite film around the bearing
parts.bearings.film.LAYERS | cells | nothing | finite film on half of the width
parts.bearings.film.ECCENTRICITIES | values | nothing | eccentricities of a table of forces
parts.bearings.film.ANGLES | values | nothing | directions of motion of a table of forces
parts.bearings.film.TURNS | values | nothing | places of a pad between grooves in a table of forces
parts.bearings.film.DIRECTIONS | values | nothing | directions of the rates in the table of a pad
parts.bearings.film.PAD_CELLS | cells | nothing | finite film around a pad
parts.bearings.film.PAD_LAYERS | cells | nothing | finite film on half of the width of a pad
parts.bearings.journal.TRIED | angles | nothing | between which the place of a journal in a bearing with grooves is found
parts.bearings.journal.MOST | iterations | nothing | by which the eccentricity under a load is found
parts.bearings.journal.NODES | places | nothing | quadrature along a face of an oiled slider
parts.bearings.laws.COLDEST | degC | nothing | coldest oil of Walther's law
parts.bearings.laws.HOTTEST | degC | nothing | hottest oil of Walther's law
parts.bearings.laws.THINNEST_OIL | mm²/s | nothing | thinnest oil of Walther's law
parts.bearings.laws.NARROWEST | rad | nothing | least film between two grooves
parts.bearings.film.THINNEST | 1 | clearance | least film of a table of forces
parts.bearings.film.COARSEST | cells | nothing | from which a finite film begins without a coarser one
parts.bearings.film.ROUND_OFF | 1 | largest source | source of a film that is none
parts.bearings.film.MOST_SETS | iterations | nothing | most iterations to the border of a finite film
parts.wear.worn_guide.MOST_TRIALS | trials | nothing | by which the place nearest to a worn side is found
parts.wear.worn_guide.CLOSE | 1 | distance of two places | error of this place that ends the search
parts.wear.worn_clearance.CARRIED | 1 | normal force | error of the force that a foundation carries
parts.wear.worn_clearance.LEAST_COSINE | 1 | nothing | cosine from the normal from which on a foundation carries
parts.wear.worn_guide.WAYS | places | nothing | to which wear goes from each half of a step along a guide
dynamics.sweeps.wear.LARGEST_INCREMENT | 1 | clearance | largest depth that is carried on at once
dynamics.sweeps.wear.SMALL_DEPTH | 1 | clearance | depth beside the largest one in the error of wear
dynamics.sweeps.wear.SAFETY | 1 | increment | factor of the next increment of wear
dynamics.sweeps.wear.LEAST_FACTOR | 1 | increment | its least change
dynamics.sweeps.wear.MOST_FACTOR | 1 | increment | its largest change
parts.contact.hysteresis.MISS | 1 | restitution | what a law may miss without a warning
parts.contact.hysteresis.SMALL_CHI | 1 | chi | below it a series is summed
parts.contact.hysteresis.TERMS | terms | nothing | terms of that series
parts.contact.hysteresis.SERIES_FROM | 1 | restitution | from it on the series serves
parts.contact.validity.WIDE | 1 | radius of the journal | half-width of a contact that gets a remark
parts.contact.validity.SMALL_EXCESS | 1 | largest force | force above a free impact's that goes without a remark
parts.contact.hysteresis.SMALL_SHARE | 1 | impulse, loss | slow contacts that go without a remark
parts.contact.validity.SMALL_TENSION | 1 | largest force | cut tension that goes without a remark
parts.bodies.rigid.SAME_POINT | 1 | distance from the origin | distance from a particle that is none
parts.bodies.rigid.NO_MOMENT | 1 | forces of a part | moment on a particle that is round-off
parts.joints.revolute.TOUCHING | 1 | clearance | round-off of a start that touches
engine.sensitivity.tangent_step.LEAST_FADING_GAMMA | 1 | method | gamma below which errors of accelerations stay
engine.sensitivity.tangent_step.STATE_DIFFERENCE | 1 | size of the mechanism | differences of states for a derivative
engine.step.runge_kutta.PROJECTIONS | iterations | nothing | projections of a Runge-Kutta step
engine.step.runge_kutta.MOST_REPETITIONS | iterations | nothing | rounds that friction in joints takes there
engine.radau.method.LARGEST_GROWTH | 1 | a step | most that a step of Radau's method grows at once
engine.radau.method.LEAST_GROWTH | 1 | a step | most that it is shortened at once
engine.radau.method.LEAST_STEPS | steps | a period or a run | fewest steps of Radau's method without clearance
engine.radau.method.LEAST_STEPS_CONTACTS | steps | a period or a run | the same with clearance
engine.radau.step.MOST_ITERATIONS | iterations | nothing | most Newton iterations of a step of Radau's method
engine.radau.step.REFACTOR_RATE | 1 | a correction | rate of corrections that asks for new factors
engine.radau.step.REFACTOR_ITERATIONS | iterations | nothing | iterations that ask for new factors
engine.radau.step.ITERATION_FRACTION | 1 | accepted error, rtol^(1/2) | what Newton's iterations leave
engine.radau.step.FIXED_STEP_TOLERANCE | 1 | h^2 a | the same for steps of one size
engine.radau.step.LEAST_TOLERANCE | 1 | h^2 a | least that is asked for
engine.radau.step.CLOSED_SHIFT | 1 | size of the mechanism | shift onto the joints that is round-off
engine.radau.step.STALLED_SHIFT | 1 | size of the mechanism | shift that is round-off if it gets no smaller
engine.radau.step.LARGE_SHIFT | 1 | size of the mechanism | shift that is taken by full projections
engine.radau.step.STALLED_RATE | 1 | a correction | ratio of corrections that are round-off
engine.radau.step.ACCELERATION_MISMATCH | 1 | accelerations | difference to interpolated ones that shows stiff forces
engine.radau.step.INSENSITIVE | 1 | that difference | change by other interpolated positions that shows a kink
engine.radau.step.LEAST_RATE | 1 | a correction | rate that a first iteration is trusted with
engine.dormand_prince.method.LARGEST_GROWTH | 1 | a step | most that a step of Dormand and Prince grows at once
engine.dormand_prince.method.LEAST_GROWTH | 1 | a step | most that it is shortened at once
engine.dormand_prince.method.FAILED_GROWTH | 1 | a step | next trial after one whose stages could not be computed
engine.dormand_prince.method.LEAST_STEPS | steps | a period or a run | fewest steps of Dormand and Prince without clearance
engine.dormand_prince.method.LEAST_STEPS_CONTACTS | steps | a period or a run | the same with clearance
engine.dormand_prince.method.IMPACT_STEPS | steps | an impact | fewest steps of an impact
engine.dormand_prince.method.NEAR_RTOL | 1 | rtol | rtol from which on steps end as far from onsets as those of other methods
engine.dormand_prince.step.AT_CREST | 1 | a step | distance from a largest force at which stop conditions see it
engine.dormand_prince.step.WILD_ERROR | 1 | accepted error | error of a trial that tells nothing of events
engine.dormand_prince.step.CREST_SHARE | 1 | largest force so far | force in a step at whose place all signals are evaluated
engine.dormand_prince.step.CREST_LOOKS | thirds | a step | by which the place of the largest force is enclosed
engine.dormand_prince.step.PROJECTIONS | iterations | nothing | most projections of a state
engine.dormand_prince.step.OLD_FACTORS_RATE | 1 | the shift before | shift that asks the next projection for factors
engine.dormand_prince.complement.OTHER_POSE | 1 | size of the mechanism | distance of a pose in which the masses must be the same
engine.energy.RESIDUAL_LIMIT_RUNGE_KUTTA | 1 | energy turned over | largest residual of a Runge-Kutta run
engine.newmark.jacobian_reuse.EFFECT_LIMIT | 1 | largest entry | joints that share a force that is not unique, in the status
results.status.WARNING_FRACTION | 1 | limits of the ledger | from here on the status warns
engine.step.contact_events.ROUND_OFF_GAP | 1 | size of the mechanism | gap at the start that is a contact
engine.step.contact_events.SHORT_WAY | 1 | size of the mechanism | change of a gap in a step whose rate at onset or separation is not that of the cubic
engine.sensitivity.tangent_step.MOST_ROUNDS | iterations | nothing | iterations of a carried step
engine.sensitivity.tangent_step.CONVERGED_CHANGE | 1 | carried differences | change that is round-off
engine.sensitivity.tangent_step.DIVERGED_CHANGE | 1 | carried differences | change that has to become smaller
engine.sensitivity.tangent_step.LEAST_PIVOT | N/m | nothing | keeps a division from zero
engine.sensitivity.tangent_step.LATEST_END | 1 | a step | a force that ends later by its last change has no kink in it
engine.sensitivity.tangent_step.VERY_END | 1 | a step | an onset behind it belongs to the next step
engine.sensitivity.tangent_step.WEIGHT_OF_MASS | 1 | that of a step | mass matrix for accelerations alone
engine.sensitivity.parameters.PART_OF_INPUT | 1 | input of a law | difference of inputs for the slope of a sampled law
engine.sensitivity.parameters.LEAST_PART | 1 | largest input so far | least size by which an input is judged
engine.sensitivity.histories.PART_OF_FRICTION | 1 | friction force | change that the slopes of a step may miss
engine.sensitivity.histories.STEEPEST | 1 | secant slope | steepest slope in carried accelerations
engine.sensitivity.signal_rows.SMALL_WAY | 1 | size of the mechanism | differences of positions for signals
engine.sensitivity.signal_rows.SMALL_SPEED | 1 | largest speed | differences of velocities for signals
engine.sensitivity.signal_rows.PART_OF_GAP | 1 | gap of an open contact | its difference for signals
engine.sensitivity.signal_rows.PART_OF_PENETRATION | 1 | penetration | its difference for signals
engine.sensitivity.linearise.TIME_DIFFERENCE | 1 | a step | part of it in which a neighbour must touch
engine.sensitivity.linearise.POSE_DIFFERENCE | rad | nothing | turn over which rows of joints are differenced
engine.sensitivity.histories.RELATIVE_DIFFERENCE | 1 | histories | differences for the derivative of a law
engine.sensitivity.histories.LEAST_DIFFERENCE | 1 | histories | least difference
engine.sensitivity.histories.PART_OF_SLIP | 1 | slip of a step | differences of histories of friction in a joint
engine.sensitivity.histories.PART_OF_LOAD | 1 | normal force, or angle of a clutch | differences for histories of friction
engine.sensitivity.histories.NODE_DIFFERENCE | 1 | gap and rate | differences for the derivative of a law
engine.sensitivity.histories.LEAST_NODE_DIFFERENCE | 1 | a step | how far from an onset
statics.buckling.PATH_STRIDE | 1 | size of the mechanism | step of the path for the slope of the stiffness
statics.buckling.FLAT | 1 | second moments | points on a line
engine.system.evaluate.ISOTROPIC | 1 | stiffness | change by a turn of a stiffness without a direction
statics.buckling.TRUSTED | 1 | load factor | difference of the factor from half the load that goes without a note
statics.buckling.SMALL_MOVEMENT | 1 | size, or rad | movement under half the load that goes without a note
statics.buckling.LOAD_STEPS | steps | nothing | load steps to half the load
statics.buckling.MOST_ITERATIONS | iterations | nothing | most iterations of such a step
statics.buckling.FOUND_STEP | 1 | size, or rad | correction of an equilibrium that is found
statics.buckling.LONGEST_STEP | 1 | size, or rad | longest correction
statics.buckling.EIGENVALUE_ROUND_OFF | 1 | largest | factor that counts as none
statics.buckling.ASYMMETRY | 1 | entries | difference that makes loads follow the motion
statics.buckling.MISSED | 1 | a shape | residual of a load factor that is found
statics.eigen.SLOW | 1 | largest omega^2 | modes below it are refined
statics.eigen.SLOWEST | 1 | largest omega^2 | the same in the watch of vibrations
statics.eigen.LOOKED_FOR | 1 | an eigenvalue | accuracy with which a lower one is looked for
statics.eigen.COPIES | 1 | an eigenvalue | accuracy of further copies of eigenvalues with damping
statics.eigen.DENSE_COORDINATES | unknowns | nothing | up to it matrices are dense
statics.eigen.FEW_MODES_COORDINATES | unknowns | nothing | the same where few modes are asked for
statics.eigen.DENSE_QUADRATIC_COORDINATES | unknowns | nothing | the same with damping
engine.linalg.dense.DENSE_UNKNOWNS | unknowns | nothing | up to it start values are found dense
engine.linalg.symbolic.LARGEST_SHARE | 1 | memory of the machine | positions of updates that are refused
statics.modes.ENERGY_ROUND_OFF | 1 | frequencies | round-off of a frequency
statics.equilibrium.OTHER_MODEL_STEP | 1 | a mode | part of another
statics.modes.ASYMMETRY_ROUND_OFF | 1 | entries | round-off of a symmetric matrix
statics.modes.ASYMMETRY_OF_DIFFERENCES | 1 | entries | the same with controllers, whose inputs are differenced
statics.eigen.DENSE_MOTIONS | motions | nothing | up to it matrices of rigid motions are dense
statics.eigen.ROW_ROUND_OFF | 1 | terms of a row | entry of a constraint on a body that is round-off
statics.eigen.DEPENDENT_ROW | 1 | rows | motion that rows allow
statics.eigen.FREE_FORCE | 1 | stiffness | motion that nothing resists
statics.eigen.STIFFNESS_ROUND_OFF | 1 | entries | entry of a motion that is round-off
statics.eigen.SMALL_SHARE | 1 | a motion | part of it that is named
engine.linalg.dense.GOOD_RESIDUAL | 1 | right-hand side | residual of a system that was solved
engine.linalg.dense.ROUND_OFF | 1 | right-hand side | residual that needs no better
engine.linalg.dense.SINGULAR_GROWTH | 1 | right-hand side | solution of a matrix that counts as singular
engine.linalg.dense.SCALING_ROUNDS | rounds | nothing | rounds that scale rows and columns
statics.start.consistent.SPARSE_ENTRIES | entries | nothing | up to it loops are closed by a dense least-squares solution
engine.linalg.rank.CERTAIN_INVERSE | 1 | rows of unit length | inverse of G G^T of rows that are independent beyond doubt
engine.system.state_evaluation.LARGE_UNKNOWNS | unknowns | nothing | above it factors are kept for the next matrices
engine.linalg.large.DIAGONAL_SHARE | 1 | column | pivot on the diagonal that is taken
engine.linalg.large.EXACT | 1 | terms of an equation | error of a solution by factors of another matrix
engine.linalg.large.FLOOR | 1 | largest terms | terms of an equation that are none
engine.linalg.large.MOST_REFINEMENTS | rounds | nothing | refinements by factors of another matrix
engine.linalg.large.SLOWEST | 1 | error before | refinement that is too slow
engine.linalg.large.REGULAR | 1 | scaled matrix | inverse of a matrix that is regular beyond doubt
engine.linalg.large.JOINT_COMPLIANCE | 1 | stiffness | give of rows that may repeat one another
engine.linalg.large.HOLD | 1 | stiffness | stiffness of constraints beside it while signs are counted
engine.linalg.large.DENSE_PIVOTS | unknowns | nothing | up to it eigenvalues are counted dense
engine.linalg.ordering.LARGE_GRAPH | blocks | nothing | above it SuperLU orders
statics.eigen.MOST_RESTARTS | restarts | nothing | search for load factors among those without end
statics.equilibrium.STEP_ACCURACY | 1 | Newton's correction | its error in a large model
statics.equilibrium.TANGENT_ACCURACY | 1 | length of a tangent | its error in a large model
parts.bodies.rigid.MANY_PARTS | parts | nothing | above it compiled kernels tell what turns a particle
parts.controllers.control.FILTER_RATIO | 1 | kd / kp | filter of the derivative, where none is given
engine.differences.DIFFERENCE | 1 | gap, gap rate, slip, normal force | differences for the derivatives of a force alone
engine.differences.LEAST_GAP | m | nothing | least difference of a gap
engine.differences.LEAST_SPEED | m/s | nothing | least difference of a gap rate or a slip
engine.differences.LEAST_LOAD | N | nothing | least difference of a normal force
engine.system.elements.RELATIVE_DIFFERENCE | 1 | an input or a state | differences of a control law
engine.system.elements.LEAST_SIZE | 1 | nothing | inputs and states are differenced as if this large
design.parameters.DISTANCE | 1 | size of the parameter | first distance of the mechanisms whose numbers are differenced by a parameter
design.parameters.SMALLER | 1 | the distance before | next distance, where two orders of differences disagree
design.parameters.LARGER | 1 | the distance before | next distance, where they disagree because of round-off
design.parameters.TRIES | 1 | nothing | largest number of distances
design.parameters.ORDERS_AGREE | 1 | slope | difference of two orders, to which a distance is good
design.parameters.LEAST_SLOPE | 1 | largest slope of the neighbours | least slope beside which this difference is judged
design.parameters.FELT | 1 | a number, or coordinates | least change of a number of a program that is judged, if any is larger
design.parameters.FINER | 1 | distance of the neighbours | distance for laws of sampled controllers
design.parameters.DIFFERENCE_OF_NUMBERS | 1 | distance of the neighbours | first step of differences of kernels by a parameter
design.parameters.STEPS_AGREE | 1 | slope of forces and equations | difference of slopes with one step and two, to which a step is good
design.parameters.SHAKEN | 1 | size of the mechanism | shift to the state at which such steps are judged
engine.system.elements.COORDINATE_DIFFERENCE | m, rad | nothing | differences of signals that controls read
engine.newmark.implicit_step.STATE_ROUND_OFF | 1 | a state of a control | corrections below this part are round-off
engine.newmark.implicit_step.LEAST_CORRECTION | 1 | nothing | least tolerance of a correction, for what stays 0
engine.newmark.error_control.LEAST_STATE | 1 | nothing | least scale of a state of a control that stays 0
statics.start.consistent.SETTLED | 1 | a state of a control | last correction of states that begin at rest
run.sampling.SETTLED | 1 | a state of a control | the same of sampled controllers
run.sampling.DIFFERENCE | 1 | a state of a control | differences of a sampled law
run.sampling.MOST_ITERATIONS | iterations | nothing | most rounds to states that begin at rest
statics.start.consistent.CLOSED_GAP | 1 | size of the mechanism | gap of a projected pose
statics.start.consistent.FAR_GAP | 1 | largest coordinate | the same far from the origin
statics.start.consistent.MOST_PROJECTIONS | iterations | nothing | most rounds of a projection
parts.bodies.rigid.MASSLESS | 1 | smallest mass of other bodies | mass of a massless link
elastic.planes.plane_body.PIN_SHARE | 1 | mass of the body | mass of an averaged pin, taken from its nodes
engine.newmark.jacobian_reuse.ROUND_OFF_SPREAD | 1 | correction that was round-off | another one that may be
statics.start.consistent.NO_ENERGY | 1 | largest inertia | inertia of bodies without any, for start velocities
statics.start.consistent.YIELD | 1 | 1 / largest inertia | compliance of velocity rows at the start of a large model | 0.01 0.1 10 100
statics.start.consistent.MOST_ROUNDS | rounds | nothing | most rounds in which these rows become rigid | 0.1 10
statics.start.consistent.SETTLED_VELOCITY | 1 | largest start velocity | change of a round that may be round-off
statics.start.consistent.ROUND_OFF_OF_RATES | 1 | largest rate of the drives | start velocity that is round-off
statics.start.consistent.RATES | intervals | period of a drive | instants at which its rate is looked at
statics.start.consistent.NO_INERTIA | 1 | largest inertia | motion of massless links alone
statics.start.consistent.SHARE | 1 | a motion | part of it of a link that is named
statics.start.consistent.POSE_SHIFT | rad | nothing | how far a pose is moved to see which rows repeat others
statics.equilibrium.MOST_STRIDES | strides | nothing | most strides to a pose at rest
statics.equilibrium.STRIDE_ITERATIONS | iterations | nothing | most iterations of a stride
statics.equilibrium.LARGEST_STRIDE | 1 | size, or rad | longest stride
statics.equilibrium.REST_STRIDE | 1 | size, or rad | stride of a pose at rest
statics.equilibrium.SPEED_TOLERANCE | 1 | angular speed | bodies that spin alike
statics.eigen.STIFFNESS_ASYMMETRY | 1 | stiffness | above it a stiffness has no potential
statics.equilibrium.MOST_ITERATIONS | iterations | nothing | most iterations of an equilibrium
statics.equilibrium.MOST_OF_LONG_STEP | iterations | nothing | the same of a load step that is longer than asked for
statics.equilibrium.STEP_ROUND_OFF | 1 | size, or rad | correction that is round-off
statics.equilibrium.SAME_FORCES | 1 | largest multiplier | forces by multipliers that are balanced
statics.equilibrium.RESTS | iterations | nothing | the same where multipliers are round-off
statics.equilibrium.FOLLOWED | 1 | load step | difference from the tangents up to which a load step may be longer than asked for
statics.equilibrium.LONG_LOAD_STEP | 1 | what tangents see | a load step that is longer is halved
statics.equilibrium.SNAP_LOAD_STEP | 1 | what tangents see | the same at the smallest size: refused
statics.equilibrium.CLOSED_GAP | 1 | size of the mechanism | gap of a joint in equilibrium
statics.equilibrium.BENT | 1 | way at a contact | difference of its gap from its tangents, above which a stride or load step is shortened
statics.equilibrium.LEAST_BENT | 1 | size of the mechanism | the least such difference
run.simulate.OTHER_SPEED | 1 | velocities of a steady rotation | velocities that joints and drives share
statics.equilibrium.LEAST_JUMP | 1 | loads | when two equilibria are the same
dynamics.sections.ROUNDS | iterations | nothing | most rounds to a crossing
dynamics.sections.HALVINGS | halvings | nothing | most halvings of a step there
dynamics.sections.CLOSE | 1 | a step | how near a crossing has to be
dynamics.verdict.RETURNS | returns | nothing | returns that make a cycle
dynamics.verdict.TAIL | points | nothing | least points of a cycle
dynamics.verdict.LONGEST | points | nothing | longest cycle that is looked for
dynamics.lyapunov.PART | 1 | points of the first run | the second run has one in so many
dynamics.lyapunov.SETTLES | 1 | points of the first run | the second run leaves out one in so many
dynamics.lyapunov.LEAST | points | nothing | points of the second run, at least
dynamics.lyapunov.SECOND_RUN_APART | 1 | size of the state | distance of the other start
dynamics.verdict.LEAST_IN_DOUBLED_BAND | points | nothing | points of a band that doubles
dynamics.verdict.FINER | 1 | mean square | what a doubling leaves at most
dynamics.verdict.FEWEST_DOUBLINGS | doublings | nothing | fewest that accumulate
dynamics.verdict.BLOCKS | blocks | nothing | parts of a record that are laid on a line
dynamics.verdict.LEAST_BLOCKS | blocks | nothing | fewest of them
dynamics.verdict.LEAST_OF_BLOCK | points | nothing | points of one
dynamics.verdict.STRAIGHT | 1 | mean square | share of the line in a drift
dynamics.verdict.LEAST_IN_BAND | points | nothing | points of a band whose mean is taken away
dynamics.exponents.BLOCKS | blocks | nothing | blocks that an error is taken from
dynamics.exponents.FEWEST_BLOCKS | blocks | nothing | fewest of them
dynamics.exponents.POWER | 1 | logarithm of time | growth like this power of time is none
dynamics.exponents.LOGS | 1 | round-off | error of a logarithm
dynamics.exponents.WITHIN | 1 | errors | exponents that do not differ
dynamics.exponents.CLEARLY | 1 | errors | a second exponent that speaks against a regular motion
dynamics.exponents.FEWEST | intervals | nothing | fewest for an error
dynamics.exponents.SETTLING | intervals | nothing | those that directions need to settle
dynamics.orbits.periodic_orbit.REAL | 1 | a multiplier | imaginary part that is none
dynamics.orbits.periodic_orbit.NEAR | 1 | a multiplier | distance from 1 that names a bifurcation
dynamics.orbits.continuation.SHARPEST | 1 | cosine | sharpest turn of a branch between points
dynamics.orbits.continuation.FEW | iterations | nothing | a step grows below
dynamics.orbits.continuation.MANY | iterations | nothing | a step shrinks above
dynamics.orbits.continuation.CORRECTIONS | iterations | nothing | most corrections of a point
dynamics.orbits.continuation.LOCATED | 1 | a step of a branch | accuracy of a bifurcation
dynamics.orbits.shooting.SAMPLES | points | period | where a grazing is looked for
dynamics.orbits.shooting.FINER | points | a sample | the same, near it
dynamics.orbits.shooting.SHARP | 1 | a multiplier | change that shows a grazing
dynamics.systems.impact_ode.PILE | 1 | interval | impacts that are closer pile up
dynamics.systems.compiled_ode.LEAST_STEP | 1 | time | least step of a compiled equation
dynamics.systems.compiled_ode.DIFFERENCE | 1 | size of the state | difference for the rate of a compiled gap
dynamics.systems.compiled_ode.SHORT | 1 | a step | most time of that difference
dynamics.systems.compiled_ode.SHORTEST | 1 | a step | least time of that difference
dynamics.systems.impact_ode.STEPS | steps | nothing | least steps of a period for turning points of the gap
dynamics.orbits.continuation.QUARTER | 1 | time to the next impact | half of a silent span, at most
dynamics.orbits.continuation.LONGEST | 1 | period | half of a silent span, at most
dynamics.orbits.continuation.CLOSE_TO_GRAZING | 1 | a step of a branch | distance to grazing up to which events are sought
dynamics.orbits.continuation.SAME | 1 | period | instants of one impact
dynamics.orbits.continuation.PROBE | 1 | scales of the branch | displacement that tells on which side a gap opens
dynamics.orbits.event_curve.DIFFERENCE | 1 | range | difference of a parameter for a gradient
dynamics.orbits.event_curve.CORRECTIONS | corrections | nothing | most corrections of a point of a curve
dynamics.orbits.event_curve.FEW | corrections | nothing | a step grows up to
dynamics.orbits.event_curve.SMALLEST | 1 | first step | smallest step of a curve
dynamics.orbits.event_curve.SHARPEST | 1 | cosine | sharpest turn of a curve between points
dynamics.orbits.event_curve.PRECISE | 1 | range | accuracy of a point of a curve
dynamics.systems.dynamics.SMALL | 1 | size of the state | distance of a companion
dynamics.systems.mechanism_flow.SMALL_IN_CONTACT | 1 | size of the state | the same with contacts
dynamics.lyapunov.INTERVALS | intervals | nothing | intervals in which directions are made apart
dynamics.systems.mechanism_flow.SHORTEST | spacings | time | shortest interval
dynamics.systems.mechanism_flow.INSTANT | 1 | period | instants at which rates are compared
dynamics.systems.mechanism_flow.NUDGE | 1 | size of the state | difference for a rate
dynamics.orbits.orbit_newton.HALVINGS | halvings | nothing | most halvings of a correction
dynamics.orbits.orbit_newton.SMALLEST_SINGULAR | 1 | largest singular value | directions without a say
dynamics.orbits.orbit_newton.LARGEST_STRETCH | 1 | size of the state | longest correction
dynamics.systems.differences.STEP | 1 | coordinate | first step of a difference of an own function
dynamics.systems.differences.RUNG | 1 | nothing | ratio of two steps that are tried
dynamics.systems.differences.RUNGS | steps | nothing | most steps that are tried in one direction
dynamics.systems.differences.NEAR | 1 | a step | place of the point that tests a difference
dynamics.systems.differences.ACCEPTED | 1 | slope | difference of slopes of an accepted step
dynamics.systems.differences.CLEAR | 1 | round-off | bend of a function
dynamics.systems.differences.FALLEN | 1 | a bend | fall of bends that is no chance
dynamics.systems.differences.VANISHING | 1 | largest coordinate | coordinate that counts as zero
dynamics.systems.differences.FARTHEST | 1 | largest coordinate, or 1 | largest step of a difference
dynamics.systems.differences.DISTANCES | 1 | largest coordinate, or 1 | states at which a dependence is sought
dynamics.systems.given.FINEST | 1 | state | finest tolerance of a second run
dynamics.systems.given.TANGENT_ATOL | 1 | tangents | absolute tolerance of carried differences
dynamics.orbits.periodic_orbit.TOLERANCE | 1 | size of the state | what does not come back
dynamics.orbits.periodic_orbit.TOLERANCE_OF_STEPS | 1 | size of the state | the same with error-controlled steps
dynamics.orbits.periodic_orbit.AMPLIFIED | 1 | tolerance | what a multiplier may make of it
dynamics.orbits.periodic_orbit.AT_REST | 1 | size of the state | an orbit that stands still
dynamics.orbits.periodic_orbit.AGAIN | 1 | size of the state and growth | a motion that does not come back after twice its period
dynamics.orbits.periodic_orbit.AGAIN_OF_STEPS | 1 | size of the state and growth | the same with error-controlled steps
dynamics.orbits.periodic_orbit.ENLARGED | 1 | usual differences | how sure multipliers of differences are
dynamics.orbits.periodic_orbit.LARGEST_SPREAD | 1 | multiplier or 1 | whether a sentence tells that they are uncertain
dynamics.lyapunov.TOO_MUCH | 1 | a difference | growth that asks for shorter intervals
dynamics.lyapunov.FAR_TOO_MUCH | 1 | a difference | growth that is repeated
dynamics.lyapunov.LOST | 1 | largest direction | direction that is lost
dynamics.lyapunov.MOST_LOOKS | looks | an interval | most looks
dynamics.sections.PERIODS | periods | period | longest way to a section
dynamics.sections.PACES | paces | first pace | the same without a period
dynamics.sections.AHEAD | 1 | a step | distance from a section that has been left
dynamics.verdict.GROUP | 1 | spread | signals that move together
dynamics.verdict.SEPARATE | 1 | noise | signals that differ
dynamics.verdict.SUCCESSORS | steps | nothing | successors of neighbours
dynamics.verdict.LEAST_WAY | 1 | logarithm of a distance | least growth that counts
dynamics.orbits.shooting.SMALL | 1 | size of the state | differences for derivatives of maps
dynamics.orbits.shooting.SMALL_OF_A_FLOW | 1 | size of the state | the same for flows
dynamics.verdict.LEAST | points | nothing | least points of a verdict
dynamics.verdict.LEAST_APERIODIC | points | nothing | the same, of no period
dynamics.verdict.LEAST_CHAOTIC | points | nothing | the same, of chaos
dynamics.verdict.CLEARLY | 1 | standard errors | an exponent that is not zero
dynamics.verdict.REGULAR | 1 | separation of random points | separation of a regular motion, at most
dynamics.verdict.PARTED | 1 | separation of random points | separation of chaos, at least
dynamics.verdict.TOGETHER | 1 | separation of random points | separation below which the 0-1 test is not asked
dynamics.verdict.SETTLED | 1 | spread | drift of what has settled
dynamics.verdict.MOST_SIGNALS | signals | nothing | signals that are tested
dynamics.verdict.PART | 1 | record | lags of the 0-1 test: one over this part
dynamics.verdict.RELATIVE | 1 | spread | points that are the same
dynamics.basins.KEPT | points | nothing | points that are remembered
dynamics.basins.CLOSE | 1 | tolerance | points that may be the same
dynamics.basins.SAME | 1 | size of the state | points that are the same
dynamics.series.embedding.LEAST_OF_DIMENSION | points | nothing | least points
dynamics.series.embedding.PERIODS | periods | nothing | least periods
dynamics.series.embedding.DIMENSION_REFERENCES | points | nothing | reference points
dynamics.series.embedding.PER_E | radii | factor e | radii
dynamics.series.embedding.SPAN | 1 | logarithm of a radius | least length of a straight part
dynamics.series.embedding.EVEN | 1 | slope | what is straight
dynamics.series.embedding.LEAST | points | nothing | least points
dynamics.series.embedding.FALSE_SHARE | 1 | neighbours | false ones that may be left
dynamics.series.exponent.LEAST | points | nothing | least points
dynamics.series.exponent.PERIODS | periods | nothing | least periods
dynamics.series.exponent.BLOCKS | blocks | nothing | blocks that an error is taken from
dynamics.series.exponent.MARGIN | 1 | logarithm of a distance | end of a straight part
dynamics.series.exponent.LEAST_RISE | 1 | logarithm of a distance | least rise
dynamics.series.exponent.FINITE | 1 | distances | those that are not small any more
dynamics.series.exponent.FLOW | 1 | logarithm of a distance | a flow, not a map
dynamics.series.exponent.KANTZ_REFERENCES | points | nothing | reference points
dynamics.series.exponent.NEIGHBOURS | points | nothing | neighbours of each
dynamics.series.exponent.ROSENSTEIN_REFERENCES | points | nothing | reference points
dynamics.series.samples.LARGEST | 1 | nothing | largest sample whose square is a number
dynamics.series.samples.ROUND_OFF | 1 | spacing | uneven spacing
dynamics.series.samples.LOBE | bins | nothing | half-width of a line
dynamics.series.samples.ABOVE_FLOOR | 1 | median | height of a line
dynamics.series.samples.AROUND | bins | nothing | width of the median
dynamics.series.samples.LINES | 1 | power | power in lines of what is periodic
dynamics.series.samples.BROAD | 1 | power | the same of what is broad
dynamics.series.exponent.CANDIDATES | points | nothing | neighbours that are looked at
dynamics.series.exponent.BIAS | 1 | exponent | bias that is accepted
dynamics.series.exponent.LASTING | 1 | neighbours | those that last
dynamics.series.exponent.SMALLEST | 1 | spread | smallest distance
dynamics.series.samples.ENOUGH | points | nothing | least points
dynamics.series.samples.REGULAR | 1 | 0-1 test | regular below
dynamics.series.samples.CHAOTIC | 1 | 0-1 test | chaotic above
dynamics.report.ENOUGH | samples | period | most for estimates from a signal
dynamics.report.LEAST | points | nothing | least points of a 0-1 test
engine.linalg.symbolic.WIDEST_PANEL | unknowns | nothing | widest supernode
engine.linalg.symbolic.PANEL_ZEROS | 1 | entries | zeros that supernodes may hold
elastic.beams.stress.NEAR_END | thirds of an element | stress | way from an end up to which a stress belongs to its node
elastic.beams.stress.CLEAR | 1 | stress at the ends | stress within an element that is larger
parts.bodies.flexible.THIN | 1 | radius of an arc | outer fibre of an arc with the stress of a straight beam
parts.bodies.flexible.SAME_PLACE | 1 | length of a beam | node in the middle
elastic.beams.mesh.SAME_PLACE | 1 | size of the mesh | nodes at one place
elastic.beams.mesh.STRAIGHT | rad | nothing | bend of a link that is straight
elastic.beams.mesh.FARTHEST | m | nothing | largest coordinate of a mesh
elastic.meshes.mesh.ON_CIRCLE | 1 | radius | nodes on a circle
elastic.meshes.mesh.PLACES | digits | size of the mesh | decimal places of the centre of a hole
elastic.meshes.mesh.FLAT | 1 | longest side squared | Jacobian determinant of a flat cell
elastic.meshes.mesh.ON_EDGE | 1 | edge | node on the edge of another cell
elastic.meshes.outlines.SAME_NODE | 1 | size of the mesh | nodes of two blocks at one place
elastic.meshes.outlines.MOST_NODES | nodes | nothing | largest block of a mesh
elastic.meshes.outlines.CLEAR | 1 | size of the cells | distance of a plate's lattice from the boundary
elastic.meshes.outlines.ROUNDS | rounds | nothing | rounds of smoothing
elastic.meshes.outlines.FLAT | 1 | median area | triangle that is round-off
elastic.meshes.outlines.FEWEST | nodes | nothing | least nodes of a hole
elastic.meshes.outlines.NARROW | rad | nothing | widest shank whose eye ends on an arc
elastic.meshes.outlines.LARGEST_TURN | rad | nothing | turn of a fillet along one cell
elastic.meshes.outlines.NO_CORNER | 1 | radius | shank that leaves an eye without a corner
elastic.meshes.outlines.FEWEST_ON_ARC | edges | nothing | least edges of a fillet
elastic.meshes.outlines.SAME_PLACE | 1 | longest edge | ends of two fillets at one place
elastic.meshes.outlines.STRAIGHT | rad | nothing | corner that is none
elastic.meshes.outlines.STRETCHED | 1 | two sides | triangle that is flat on an arc
elastic.planes.pins.NO_ARM | 1 | size of the mesh | nodes at the point of a pin
elastic.planes.plane_body.SAME_LENGTH | 1 | length | distance of pins that fits the mesh, point of a joint that is a pin
elastic.planes.plane_body.SHIFT | 1 | longitudinal wave squared | shift of the eigenvalues
elastic.reduced.accuracy.SHIFT | 1 | lowest reduced frequency squared | shift of the eigenvalues
""")


def _left_out() -> dict[str, str]:
    """Why, by place."""
    reasons = """
    the default of an argument that is varied: parts.contact.onset.LEAST_APPROACH engine.step.step_size.RTOL
    a factor of a formula: dynamics.report.HALF parts.contact.hysteresis.HERTZ dynamics.exponents.LATE parts.contact.friction.PASSIVE
        engine.energy.GAUSS_POINT
        statics.start.consistent.WHOLE_TURN
        dynamics.verdict.TURN dynamics.orbits.shooting.TURN elastic.beams.corotational.TURN
        elastic.beams.corotational.A1 elastic.beams.corotational.A2 elastic.beams.corotational.A3 elastic.beams.corotational.A4
        elastic.beams.corotational.A5 elastic.beams.corotational.A6 elastic.beams.corotational.A7 elastic.beams.corotational.A8
        elastic.beams.corotational.A9 elastic.beams.corotational.A10 elastic.beams.corotational.FOLDED
        elastic.beams.corotational.REST elastic.beams.fem.BOW engine.step.acceptance.PAST_OF_QUADRATIC
    printed with the theory, and only a remark: parts.contact.validity.LOVE parts.contact.validity.YIELD_OF_POINT
        parts.contact.validity.YIELD_OF_LINE
    start values of histories: parts.contact.onset.HISTORY parts.contact.validity.HISTORY_WITH_EXTREMES
    a name of a code, a mode or a place in an array: statics.buckling.ENDS engine.system.evaluate.COORDINATES
        run.run.KEYBOARD run.run.TERMINATION run.checkpoint.END_COLUMN parts.joints.revolute.AT_PIN
        parts.joints.revolute.BY_ANGLES parts.joints.prismatic.OF_GUIDE parts.joints.prismatic.BY_TURN
        engine.state.record.ENERGY_MISSING engine.state.record.ENERGY_MADE
        engine.state.record.ENERGY_LOST engine.state.record.CONDITION_MET engine.state.flow.EPISODE_SIZE engine.state.flow.EPISODE_ROW_SIZE
        engine.state.flow.IMPACT_SIZE engine.state.flow.CONTACT_MEMORY_SIZE
        results.contact_intervals.IMPACT
        results.contact_intervals.CONTINUOUS
        results.netcdf.FORMAT dynamics.sweeps.store.FORMAT
        engine.newmark.implicit_step.CONTINUE engine.newmark.implicit_step.EVALUATE_AGAIN
        run.run.NOT_SAVING engine.sensitivity.tangent_step.TANGENT_LOST
        engine.step.contact_events.IMPACT engine.step.contact_events.LASTING
        engine.step.contact_events.CLOSING_PHASE engine.step.contact_events.LASTING_PHASE
        engine.linalg.lu.ROWS_HELD engine.linalg.lu.NO_ROW dynamics.sections.DOWN dynamics.sections.UP
        dynamics.systems.mechanism_flow.ONSET dynamics.basins.LOST
        dynamics.basins.UNDECIDED
        program.numbering.CONTACT_PENETRATION program.program.CONTACT_COMMON program.program.FOUR_SIZE elastic.beams.stress.SIZE elastic.beams.stress.OWN elastic.beams.stress.NODE elastic.beams.stress.SECTION_FORCES
        elastic.beams.mass_damping.POINTS model.massless.MOST
        parts.bearings.film.SHORT parts.bearings.film.LONG parts.bearings.film.TABLE parts.bearings.film.PADS
        parts.bearings.film.TABLE_BEGIN parts.bearings.journal.PLACES parts.bearings.journal.SHARES parts.bearings.laws.ABSOLUTE parts.bearings.film.LEVEL parts.bearings.film.FIELD
        parts.bearings.film.PAD_ROWS parts.bearings.film.PAD_LINES parts.bearings.film.PAD_COLUMNS parts.bearings.film.MIDDLE parts.bearings.film.PLACE
        parts.wear.worn_clearance.TABLES parts.wear.worn_guide.DEPTHS parts.wear.worn_bearing.TABLES
        parts.bearings.film.POSITIVE parts.bearings.film.HALF parts.bearings.film.WHOLE
        program.program.NO_FACTOR program.program.FIRST_OUTPUT engine.system.outputs.FRICTION_ALONE
    decides a remark or a refusal, and no number of a run: dynamics.report.FEWEST_PERIODS dynamics.report.FEWEST_SAMPLES
        dynamics.report.MORE_THAN dynamics.report.POINTS dynamics.jobs.files.NO_ROOM findings.watch.LEAST_STEPS findings.watch.SHARE
        model.part.STRAIN_AT_REST model.part.LARGE_STRAIN model.part.IMPOSSIBLE_STRAIN parts.couplings.coupling.LARGE_WIND_UP parts.couplings.coupling.COARSE_STEP
        parts.bearings.journal.THIN parts.bearings.journal.TAYLOR parts.wear.worn_joint.LARGEST_COEFFICIENT parts.wear.worn_joint.FEWEST_BINS parts.wear.worn_joint.MOST_BINS dynamics.sweeps.wear.MOST_RUNS dynamics.sweeps.wear.NARROW parts.cams.curve_on_curve.PULL parts.couplings.coupling.LARGE_STRETCH
        parts.couplings.belt.LARGE_STRETCH parts.couplings.wheels.LARGE_PLAY parts.couplings.wheels.PARTED elastic.planes.plane_body.TOO_STIFF results.stress.CAPTURED
        model.part.LEAST
        elastic.reduced.accuracy.AT_EDGE parts.loads.mesh_loads.LEFT_OUT elastic.reduced.accuracy.EDGE_SHARE elastic.reduced.accuracy.STEP_ERROR elastic.reduced.bases.LEAST_PIVOT elastic.reduced.bases.LEAST_SHARE elastic.reduced.bases.NEARLY elastic.reduced.bases.TIE design.orbits.WIDER
        elastic.reduced.accuracy.EXACT
        elastic.reduced.accuracy.LARGE_SHARE elastic.reduced.accuracy.IMPOSSIBLE_SHARE elastic.reduced.accuracy.MOST_POINTS findings.watch.IMPOSSIBLE_SHARE
        engine.state.record.MOST_POSES engine.state.record.LEAST_POSES engine.state.record.POSE_NUMBERS
        findings.watch.MOST_UNKNOWNS findings.watch.FEWEST_STEPS findings.watch.MOST_CONTROLLED findings.watch.POSES findings.watch.POSES_OF_LARGE
        findings.watch.AROUND findings.watch.DISTANCE findings.watch.LARGE findings.watch.MANY findings.watch.AROUND_OF_MANY findings.watch.FEWEST_STATES findings.watch.SAME
        statics.modes.RIGID_OF_LARGE statics.modes.DENSE statics.modes.LOWEST
        findings.watch.FEWEST_INSTANTS statics.modes.NEAR statics.modes.RIGID statics.modes.ROUND_OFF findings.watch.ENERGY_SHARE findings.watch.DECAY
        findings.watch.PART_OF_STEP findings.watch.UNRESOLVED findings.watch.CLEAR_LOSS
        findings.watch.LOST_PHASE findings.watch.LOST_AMPLITUDE run.checkpoint.EVERY results.netcdf.LARGEST_GROWTH
        findings.watch.STEP_CODES findings.watch.SHOWN_RESIDUALS findings.watch.LEAST_RESIDUAL findings.watch.LEAST_RTOL findings.watch.TRIED_STEPS
        engine.system.state_evaluation.MOST_CALLS engine.system.state_evaluation.BLOWN_UP engine.system.state_evaluation.SHOWN_NUMBERS
        engine.linalg.rank.DENSE_ROWS engine.linalg.rank.IN_COMBINATION statics.eigen.LONGEST_SEARCH
        statics.equilibrium.INDEPENDENCE
        statics.equilibrium.ROUND_OFF engine.linalg.large.DENSE_COLUMNS engine.linalg.large.FIRST_VECTORS engine.linalg.large.VANISHING engine.linalg.large.REGULARISATION
        engine.linalg.large.LEAST_PIVOT engine.linalg.large.ITERATIONS run.stopping.SAME run.stopping.LEAST run.stopping.FINEST run.stopping.MOST_TRIALS
        run.stopping.TIMES_TARGET parts.controllers.control.JUST_BEFORE parts.controllers.control.LATEST_BREAK parts.controllers.control.TARGETS
        results.stress.SAME_NUMBERS run.saving.SAME_TIME run.saving.LARGEST_SHARE run.saving.SURE_SIZE run.run.LEAST_SEEN run.run.LEAST_CLEAR
    round-off of a time, from which a saved instant is the end of its step: engine.step.acceptance.END_OF_STEP run.saving.SAME_INSTANT
    round-off of the end of a run, four times: parts.drives.motions.SHORTEST_PULSE
    refuses what would take too long: parts.controllers.control.LEAST_SAMPLE
    squares of smaller numbers are 0 among floats: run.simulate.SHORTEST_RUN
    stands for infinity: engine.state.record.NEVER
    stands for a clearance that does not exist: parts.joints.stop.NO_CLEARANCE
    a size of a buffer, a block or a store: dynamics.jobs.executors.PENDING dynamics.jobs.files.DIGEST
        elastic.reduced.reduced.REMEMBERED engine.state.flow.PAST_STATES run.run.BUFFER_ROWS
        run.run.BLOCK_SECONDS run.run.FIRST_BLOCK_UPDATES dynamics.basins.CHUNKS dynamics.series.embedding.BLOCK
        dynamics.series.embedding.BLOCK program.compiler.BEHIND program.compiler.REMEMBERED_CALLS program.structure.REMEMBERED_STRUCTURES
        engine.sensitivity.signal_rows.STEP_ROWS program.structure.REMEMBERED_UNKNOWNS program.structure.FIELDWISE_FROM run.run.BUFFER_NUMBERS run.run.LEAST_BUFFER_ROWS
    size of a symbol in a picture: results.drawing.COILS results.drawing.WIDTH results.drawing.ARROW results.drawing.HEAD parts.loads.mesh_loads.ARROWS parts.loads.mesh_loads.NO_ARROW
        results.drawing.CIRCLE_POINTS results.drawing.ARC_POINTS results.drawing.OVERHANG
    how many are printed or written: dynamics.report.LINES dynamics.report.ROUND_OFF dynamics.jobs.progress.EVERY
        results.positions.SEEN results.positions.ROUND_OFF results.status.MOST results.solution.MOST_OF_A_KIND results.status.PANELS statics.start.consistent.LISTED_PARTS results.vtk.MOST_FRAMES results.contact_intervals.SHOWN_ROWS
        model.signal.MOST_COMPARED_NAMES results.solution.IN_TEXT results.solution.IN_TABLE results.solution.ROUND_OFF
        statics.modes.SHOWN_MODES dynamics.exponents.SHOWN
    shortens what another number decides: engine.linalg.rank.CERTAIN_EIGENVALUE
    coefficients and stages of Radau's method, exact: engine.radau.collocation.C engine.radau.collocation.ESTIMATE
        engine.radau.collocation.FROM_IM engine.radau.collocation.FROM_RE engine.radau.collocation.FROM_REAL
        engine.radau.collocation.LAST engine.radau.collocation.MIDDLE engine.radau.collocation.ONCE
        engine.radau.collocation.PAIR_IM engine.radau.collocation.PAIR_RE engine.radau.collocation.REAL
        engine.radau.collocation.STAGES engine.radau.collocation.TO_IM engine.radau.collocation.TO_RE
        engine.radau.collocation.TO_REAL engine.radau.collocation.TWICE engine.radau.collocation.WEIGHTS
        engine.radau.collocation._ROOT
    the published estimate of the method of Dormand and Prince: engine.dormand_prince.step.THIRD_ORDER_SHARE
        dynamics.systems.compiled_ode.THIRD_ORDER_SHARE dynamics.systems.compiled_ode.STAGES dynamics.systems.compiled_ode.ORDER
    factors of step sizes, those of scipy: dynamics.systems.compiled_ode.SAFETY
        dynamics.systems.compiled_ode.LEAST_FACTOR dynamics.systems.compiled_ode.LARGEST_FACTOR
    spacing of numbers: dynamics.systems.differences.ROUND_OFF dynamics.systems.compiled_ode.ROUND_OFF
    exact for what it integrates, or arbitrary instants: elastic.beams.fem.QUADRATURE_ORDER dynamics.systems.given.INSTANTS
    """
    found, reason = {}, ""
    for word in reasons.split("\n"):
        head, colon, rest = word.partition(": ")
        reason = head.strip() if colon else reason
        found |= dict.fromkeys((rest if colon else head).split(), reason)
    return found


LEFT_OUT = _left_out()
"""Reason by place; names that are unpacked from a range are enumerations, and left out without being listed."""
