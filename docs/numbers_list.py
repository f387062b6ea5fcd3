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
contact.onset.crossing#40 | iterations | nothing | most iterations for the instant of an onset | 0.05 0.1 10
contact.onset.crossing#1e-15 | 1 | a step | accuracy of the instant of an onset | 0.01 0.1 10 100 1e6
integrate.control.TURNS | trials | nothing | most trials of one step that look for a contact | 0.125 0.5 10
integrate.control.SAME | 1 | a step | a step is not shortened for less | 0.1 0.5 1.05
integrate.control.GROWS | 1 | a step | a step is not lengthened for less | 0.84 1.25 1.6
integrate.control.velocity_constant#0.02 | 1 | method | floor of the error constant of velocities
integrate.control.error_ratio#0.05 | 1 | method | floor of the error constant of positions
integrate.control.missed#12.0 | 1 | method | error of a first step: change of the acceleration over this
integrate.control.SAFETY | 1 | a step | safety factor of the next step | 0.1 0.5 1.1
integrate.control.allowed#0.2 | 1 | a step | most that a step is shortened at once | 0.1 0.5 2
integrate.control.allowed#2.0 | 1 | a step | most that a step grows at once | 0.6 2 10
integrate.control.met#0.25 | 1 | a step | what becomes of a step that did not converge | 0.1 0.5 2
integrate.held.CLOSED | 1 | size of the mechanism | gap of a row that may be held
integrate.held.ASIDE | 1 | way h^2 a | gap of a row that may be held in the first steps
integrate.held.STILL | 1 | largest term of a pivot | with what rows are held within a step that holds some
integrate.held.PASSING | steps | nothing | steps that pass a singular position | 0.34 10 100
integrate.held.free_gap#0.01 | 1 | size of the mechanism | cap of that way
integrate.landing.REACH | 1 | step of an impact | a contact begins, or has ended, within this part of it
integrate.landing.PROBE | 1 | duration of an impact | first trial of an impact
integrate.landing.CROSSING | 1 | step of an impact | step just into a contact whose force jumps
integrate.landing.DURATION | 1 | depth / approach speed | estimate of the duration of an impact | 0.1 0.5 2 10
integrate.landing.STEEPEST | 1 | approach speed / duration | estimate of the largest acceleration | 0.1 0.5 2 10
integrate.landing.LESS | 1 | step of an impact | a step is changed within an impact below this | 0.01 0.1 1.2
integrate.landing.MORE | 1 | step of an impact | a step is changed within an impact above this | 0.65 10 100
integrate.landing.LASTS | 1 | estimated duration | an impact that takes longer is left to the error
integrate.landing.LEAST_DIP | 1 | size of the mechanism | a dip of a gap below zero that may be round-off
integrate.landing.find_jump#0.001 | 1 | depth of a step | depth at which a jump of the force is looked for
integrate.landing.find_jump#0.1 | 1 | force of a step | smallest force there that is a jump | 0.01 0.1 9
integrate.landing.located#1.3 | 1 | steepest change | an impact's step that changes more is refused | 0.1 0.5 10 100
integrate.landing.located#0.2 | 1 | a step | most that a step within an impact is shortened at once | 0.1 0.5 4
integrate.landing.impact_step#0.5 | 1 | approach speed | rate from which a trial has rebounded | 0.1 0.5 2 10
integrate.landing.impact_step#0.001 | 1 | energy of an approach | least part of it that an impact took
integrate.landing.lasting#0.5 | 1 | duration of an impact | what forces of flight make of it | 0.01 0.1 10
integrate.landing.remember#0.4 | 1 | energy of an approach | left of it when the step is checked | 0.01 0.1 2
integrate.landing.remember#0.9 | 1 | energy of an approach | left of it when the step is checked | 0.5 1.1
integrate.ledger.MISSING | 1 | energy turned over | largest residual of a run that is ok
integrate.ledger.TAKEN | 1 | energy turned over | largest energy that the steps take or make
integrate.ledger.IN_CONTACTS | 1 | energy through contacts | largest energy that the steps take or make there
integrate.ledger.FEW | 1 | energy turned over | from here on contacts are judged
integrate.ledger.PART | 1 | coordinates | round-off of a coordinate
integrate.ledger.SMALL | 1 | power of dampers | part of it from which differences of rates count
integrate.ledger.SETTLED | steps | nothing | steps before the first verdict on energies
integrate.ledger.turned_over#1e-06 | 1 | energy of heights | part of it that counts as turned over
integrate.ledger.put_in#1e-06 | 1 | energy of heights | part of it that counts as put in
integrate.newton.ROUND_OFF | 1 | coordinates | corrections below this part are round-off
integrate.newton.CHEAP | unknowns | nothing | up to so many, each iteration that rubs has its own matrix
integrate.newton.BENDS | 1 | what is wanted | size of a correction up to which its factors serve a contact
integrate.newton.OF_GAPS | 1 | round-off of corrections | round-off of a gap
integrate.newton.FIRST_TURN | rad | nothing | angles up to here have the round-off of 1 rad
integrate.newton.implicit_step#0.1 | 1 | corrections | noise, and a correction that does not get smaller | 0.01 0.1 5
integrate.predict.FADING | 1 | what an order missed | weight of what was before the last step | 0.01 0.1 1.9
integrate.reuse.LONGEST_PAUSE | steps | nothing | most steps with new factors after old ones were refused
integrate.reuse.OLDEST | steps | nothing | factors that served so many go
integrate.reuse.MOST_EXTRA | iterations | nothing | factors that cost so many go
integrate.reuse.OTHER_STEP | 1 | coefficients of a step | factors whose coefficients differ more go | 0.01 0.1 4
integrate.reuse.REGULAR | 1 | largest term of a pivot | pivot with which factors may serve again
integrate.reuse.MEASURE_AGAIN | steps | nothing | steps after which theta is measured anew
integrate.reuse.GOOD | 1 | corrections | theta with which one correction is believed | 0.01 0.1 9
integrate.reuse.FAIR | 1 | corrections | theta with which iterations go on | 0.01 0.1 3
integrate.reuse.ALIKE | 1 | slope of a law | largest change of a slope with the same factors | 0.01 0.1 1.9
integrate.reuse.GROWN | 1 | first correction before | one that is larger is not believed alone
integrate.reuse.STALE_ITERATIONS | iterations | nothing | most iterations with old factors | 0.25 10 100
integrate.reuse.LEFT | 1 | what is wanted | error that a step may be left with
integrate.reuse.PART_OF_NOISE | 1 | round-off | the same where round-off is more
integrate.reuse.UNSEEN | 1 | what is wanted | last correction after which forces are not evaluated again
integrate.reuse.RUBBING | 1 | what is wanted | the same where a contact is closed
integrate.reuse.believed#0.001 | 1 | what is wanted | a first correction below it has not grown
integrate.reuse.measured#0.05 | 1 | what is wanted | below it, theta cannot be told from round-off
integrate.run.NEWTON_TOLERANCE | 1 | way h^2 a | what is wanted of corrections
integrate.run.ITERATIONS | iterations | nothing | most iterations of Newton's method | 0.1 0.5 10
integrate.run.Run._limits#0.001 | 1 | size of the mechanism | error of positions over rtol, without clearance
integrate.run.Run._limits#0.01 | 1 | size / largest step | least speed for rtol; cap of the clearance for atol
integrate.run.Run._limits#100.0 | 1 | least clearance | way that the least speed for rtol crosses
integrate.run.Run._limits#1e-09 | 1 | largest step | smallest step
integrate.run.Run._limits#1e-12 | 1 | period | smallest step
integrate.run.Run.begin#0.001 | 1 | largest step | first step
integrate.run.Run._seems_dependent#10.0 | 1 | HOLD | pivot that seems lost at the start
integrate.steps.IMPACT_STEPS | steps | an impact | steps of an impact with rtol = 1e-4 | 0.125 0.25 4 10
integrate.steps.FEWEST | steps | an impact | fewest steps of an impact, for any rtol | 0.125 4 10
integrate.steps.FLIGHT_COUNTS | 1 | error of positions | how much more it counts in flight
integrate.steps.SMOOTH_STEPS | steps | period of the drives | largest step, without clearance
integrate.steps.LARGEST_STEPS | steps | period of the drives | largest step, with clearance | 0.04 0.1 10 40
solve.assemble.CLOSED | 1 | size of the mechanism | gap of a loop that is closed
solve.assemble.STRIDE | rad | nothing | most that the pose is turned at once at the start
solve.assemble.ITERATIONS | iterations | nothing | most iterations that close the loops | 0.1 10
solve.assemble._newton#1000.0 | 1 | CLOSED | gap of a loop that will do
solve.assemble._newton#0.3 | rad | nothing | longest correction of the start
solve.lu.THRESHOLD | 1 | largest term of a pivot | pivot that is lost
solve.lu.HOLD | 1 | largest term of a pivot | pivot of a row that may be held
solve.rank.TOLERANCE | 1 | rows of unit length | rows that repeat others
solve.start.ROUNDS | iterations | nothing | rounds that friction in joints takes at the start | 0.1 10
solve.start.check_independent#0.05 | rad | nothing | how far a pose is shaken to see dependent rows | 0.01 0.1 10
solve.start.rigid_velocities#1e-07 | 1 | largest rate | velocities at the start that contradict one another
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
integrate.control.error_ratio#0.05 integrate.control.missed#12.0 integrate.held.ASIDE integrate.landing.REACH
integrate.landing.PROBE integrate.landing.LASTS integrate.landing.LEAST_DIP integrate.landing.STEEPEST
integrate.newton.CHEAP integrate.newton.BENDS integrate.newton.ROUND_OFF integrate.reuse.ALIKE integrate.reuse.LEFT
integrate.reuse.UNSEEN integrate.reuse.RUBBING integrate.run.NEWTON_TOLERANCE
integrate.run.Run._limits#0.01 integrate.run.Run._limits#100.0
solve.lu.HOLD
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
integrate.remarks.SMALL_SHARE | 1 | impulse, loss | slow contacts that go without a remark
contact.validity.SMALL_TENSION | 1 | largest force | cut tension that goes without a remark
joints.revolute_clearance.TOUCHING | 1 | clearance | round-off of a start that touches
integrate.carrying.LINGERS | 1 | method | gamma below which errors of accelerations stay
integrate.carrying.MOVED | 1 | size of the mechanism | differences of states for a derivative
integrate.runge_kutta.PROJECTIONS | iterations | nothing | projections of a Runge-Kutta step
integrate.runge_kutta.ROUNDS | iterations | nothing | rounds that friction in joints takes there
integrate.radau.GROWS | 1 | a step | most that a step of Radau's method grows at once
integrate.radau.SHRINKS | 1 | a step | most that it is shortened at once
integrate.radau.SAFE | 1 | a step | safety factor of the next step
integrate.radau.SMOOTH | steps | a period or a run | fewest steps of Radau's method without clearance
integrate.radau.WITH_CONTACTS | steps | a period or a run | the same with clearance
integrate.radau_step.TURNS | iterations | nothing | most Newton iterations of a step of Radau's method
integrate.radau_step.SLOW_RATE | 1 | a correction | rate of corrections that asks for new factors
integrate.radau_step.SOON | iterations | nothing | iterations that ask for new factors
integrate.radau_step.PART | 1 | accepted error, rtol^(1/2) | what Newton's iterations leave
integrate.radau_step.FINE | 1 | h^2 a | the same for steps of one size
integrate.radau_step.TINY | 1 | h^2 a | least that is asked for
integrate.radau_step.CLOSED | 1 | size of the mechanism | shift onto the joints that is round-off
integrate.radau_step.FAR | 1 | size of the mechanism | shift that is taken by full projections
integrate.radau_step.STALLS | 1 | a correction | ratio of corrections that are round-off
integrate.radau_works.AGREES | 1 | accelerations | difference to interpolated ones that shows stiff forces
integrate.radau_step.LEAST_RATE | 1 | a correction | rate that a first iteration is trusted with
integrate.ledger.MISSING_IN_RUNGE_KUTTA | 1 | energy turned over | largest residual of a Runge-Kutta run
integrate.held.PART | 1 | largest entry | joints that share a force that is not unique, in the status
integrate.status.DOUBTFUL | 1 | limits of the ledger | from here on the status warns
integrate.touch.TOUCHES | 1 | size of the mechanism | gap at the start that is a contact
integrate.tangent.ROUNDS | iterations | nothing | iterations of a carried step
integrate.tangent.ALIKE | 1 | carried differences | change that is round-off
integrate.tangent.FAR | 1 | carried differences | change that has to become smaller
system.tangent.IN_TIME | 1 | a step | part of it in which a neighbour must touch
system.tangent.TURNED | rad | nothing | turn over which rows of joints are differenced
system.tangent_history.PART | 1 | histories | differences for the derivative of a law
system.tangent_history.LEAST | 1 | histories | least difference
system.tangent_history.MOTION | 1 | gap and rate | differences for the derivative of a law
system.tangent_history.AWAY | 1 | a step | how far from an onset
solve.buckling.STRIDE | 1 | loads | step of loads for the tangent of the path
solve.buckling.NO_FACTOR | 1 | largest | factor that counts as none
solve.eigen.DENSE | unknowns | nothing | up to it matrices are dense
solve.eigen.FEW | unknowns | nothing | the same where few modes are asked for
solve.eigen.DENSE_QUADRATIC | unknowns | nothing | the same with damping
solve.either.SMALL | unknowns | nothing | up to it start values are found dense
solve.modal.ROUND_OFF | 1 | frequencies | round-off of a frequency
solve.modal.FOREIGN | 1 | a mode | part of another
solve.modal.ASYMMETRY | 1 | entries | round-off of a symmetric matrix
solve.motions.ALLOWED | 1 | rows | motion that rows allow
solve.motions.UNRESISTED | 1 | stiffness | motion that nothing resists
solve.motions.ENTRY | 1 | entries | entry of a motion that is round-off
solve.motions.SMALL | 1 | a motion | part of it that is named
solve.pivoting.GOOD_RESIDUAL | 1 | right-hand side | residual of a system that was solved
solve.pivoting.ROUND_OFF | 1 | right-hand side | residual that needs no better
solve.pivoting.SINGULAR_GROWTH | 1 | right-hand side | solution of a matrix that counts as singular
solve.pivoting.SCALING_ROUNDS | rounds | nothing | rounds that scale rows and columns
solve.assemble.LARGE | entries | nothing | up to it loops are closed by a dense least-squares solution
solve.rank.INDEPENDENT | 1 | rows of unit length | inverse of G G^T of rows that are independent beyond doubt
solve.system.LARGE | unknowns | nothing | up to it start values are found with pivoting
solve.system.REFINEMENTS | rounds | nothing | refinements without pivoting
solve.system.SOLVED | 1 | right-hand side | residual of a system solved without pivoting
solve.project.CLOSED | 1 | size of the mechanism | gap of a projected pose
solve.project.ROUNDS | iterations | nothing | most rounds of a projection
solve.redundant.ASIDE | rad | nothing | how far a pose is moved to see which rows repeat others
solve.settle.STRIDES | strides | nothing | most strides to a pose at rest
solve.settle.ITERATIONS | iterations | nothing | most iterations of a stride
solve.settle.LARGEST | 1 | size, or rad | longest stride
solve.settle.AT_REST | 1 | size, or rad | stride of a pose at rest
solve.spin.SAME_SPEED | 1 | angular speed | bodies that spin alike
solve.stability.GIVE | 1 | stiffness | give of rows that may repeat one another
solve.stability.ASYMMETRY | 1 | stiffness | above it a stiffness has no potential
solve.statics.ITERATIONS | iterations | nothing | most iterations of an equilibrium
solve.statics.ROUND_OFF | 1 | size, or rad | correction that is round-off
solve.statics.JUMP | 1 | what tangents see | a load step that is longer is halved
solve.statics.SNAP | 1 | what tangents see | the same at the smallest size: refused
solve.statics.CLOSED | 1 | size of the mechanism | gap of a joint in equilibrium
solve.statics.NEAR | 1 | loads | when two equilibria are the same
analysis.crossing.ROUNDS | iterations | nothing | most rounds to a crossing
analysis.crossing.HALVINGS | halvings | nothing | most halvings of a step there
analysis.crossing.CLOSE | 1 | a step | how near a crossing has to be
analysis.cycles.RETURNS | returns | nothing | returns that make a cycle
analysis.cycles.TAIL | points | nothing | least points of a cycle
analysis.cycles.LONGEST | points | nothing | longest cycle that is looked for
analysis.confirm.PART | 1 | points of the first run | the second run has one in so many
analysis.confirm.SETTLES | 1 | points of the first run | the second run leaves out one in so many
analysis.confirm.LEAST | points | nothing | points of the second run, at least
analysis.confirm.APART | 1 | size of the state | distance of the other start
analysis.cycles.LEAST_IN_BAND | points | nothing | points of a band that doubles
analysis.cycles.FINER | 1 | mean square | what a doubling leaves at most
analysis.cycles.FEWEST_DOUBLINGS | doublings | nothing | fewest that accumulate
analysis.drift.BLOCKS | blocks | nothing | parts of a record that are laid on a line
analysis.drift.LEAST_BLOCKS | blocks | nothing | fewest of them
analysis.drift.LEAST_OF_BLOCK | points | nothing | points of one
analysis.drift.STRAIGHT | 1 | mean square | share of the line in a drift
analysis.drift.LEAST_IN_BAND | points | nothing | points of a band whose mean is taken away
analysis.exponent_error.BLOCKS | blocks | nothing | blocks that an error is taken from
analysis.exponent_error.FEWEST_BLOCKS | blocks | nothing | fewest of them
analysis.exponent_error.POWER | 1 | logarithm of time | growth like this power of time is none
analysis.exponent_error.LOGS | 1 | round-off | error of a logarithm
analysis.exponent_error.WITHIN | 1 | errors | exponents that do not differ
analysis.exponents.CLEARLY | 1 | errors | a second exponent that speaks against a regular motion
analysis.exponents.FEWEST | intervals | nothing | fewest for an error
analysis.exponents.SETTLING | intervals | nothing | those that directions need to settle
analysis.floquet.REAL | 1 | a multiplier | imaginary part that is none
analysis.floquet.NEAR | 1 | a multiplier | distance from 1 that names a bifurcation
analysis.follow.SHARPEST | 1 | cosine | sharpest turn of a branch between points
analysis.follow.FEW | iterations | nothing | a step grows below
analysis.follow.MANY | iterations | nothing | a step shrinks above
analysis.follow.CORRECTIONS | iterations | nothing | most corrections of a point
analysis.follow.LOCATED | 1 | a step of a branch | accuracy of a bifurcation
analysis.grazing.SAMPLES | points | period | where a grazing is looked for
analysis.grazing.FINER | points | a sample | the same, near it
analysis.grazing.SHARP | 1 | a multiplier | change that shows a grazing
analysis.impact_ode.PILE | 1 | interval | impacts that are closer pile up
analysis.lyapunov.APART | 1 | size of the state | distance of a companion
analysis.lyapunov.APART_IN_CONTACT | 1 | size of the state | the same with contacts
analysis.lyapunov.INTERVALS | intervals | nothing | intervals in which directions are made apart
analysis.mechanism_flow.SHORTEST | spacings | time | shortest interval
analysis.mechanism_rates.INSTANT | 1 | period | instants at which rates are compared
analysis.mechanism_rates.NUDGE | 1 | size of the state | difference for a rate
analysis.newton.HALVINGS | halvings | nothing | most halvings of a correction
analysis.newton.SMALLEST_SINGULAR | 1 | largest singular value | directions without a say
analysis.newton.LARGEST_STRETCH | 1 | size of the state | longest correction
analysis.ode.FINEST | 1 | state | finest tolerance of a second run
analysis.ode.TANGENT_ATOL | 1 | tangents | absolute tolerance of carried differences
analysis.periodic_orbit.TOLERANCE | 1 | size of the state | what does not come back
analysis.periodic_orbit.TOLERANCE_OF_STEPS | 1 | size of the state | the same with error-controlled steps
analysis.periodic_orbit.AMPLIFIED | 1 | tolerance | what a multiplier may make of it
analysis.periodic_orbit.AT_REST | 1 | size of the state | an orbit that stands still
analysis.schedule.TOO_MUCH | 1 | a difference | growth that asks for shorter intervals
analysis.schedule.FAR_TOO_MUCH | 1 | a difference | growth that is repeated
analysis.schedule.LOST | 1 | largest direction | direction that is lost
analysis.schedule.MOST_LOOKS | looks | an interval | most looks
analysis.section_map.PERIODS | periods | period | longest way to a section
analysis.section_map.PACES | paces | first pace | the same without a period
analysis.section_map.AHEAD | 1 | a step | distance from a section that has been left
analysis.section_signals.GROUP | 1 | spread | signals that move together
analysis.section_signals.SEPARATE | 1 | noise | signals that differ
analysis.separation.SUCCESSORS | steps | nothing | successors of neighbours
analysis.separation.LEAST_WAY | 1 | logarithm of a distance | least growth that counts
analysis.shooting.SMALL | 1 | size of the state | differences for derivatives of maps
analysis.shooting.SMALL_OF_A_FLOW | 1 | size of the state | the same for flows
analysis.verdict.LEAST | points | nothing | least points of a verdict
analysis.verdict.LEAST_APERIODIC | points | nothing | the same, of no period
analysis.verdict.LEAST_CHAOTIC | points | nothing | the same, of chaos
analysis.verdict.CLEARLY | 1 | standard errors | an exponent that is not zero
analysis.verdict.SETTLED | 1 | spread | drift of what has settled
analysis.verdict.MOST_SIGNALS | signals | nothing | signals that are tested
analysis.verdict.PART | 1 | record | lags of the 0-1 test: one over this part
analysis.verdict.RELATIVE | 1 | spread | points that are the same
analysis.watched.KEPT | points | nothing | points that are remembered
analysis.watched.CLOSE | 1 | tolerance | points that may be the same
analysis.watched.SAME | 1 | size of the state | points that are the same
analysis.series.correlation.LEAST | points | nothing | least points
analysis.series.correlation.PERIODS | periods | nothing | least periods
analysis.series.correlation.REFERENCES | points | nothing | reference points
analysis.series.correlation.PER_E | radii | factor e | radii
analysis.series.correlation.SPAN | 1 | logarithm of a radius | least length of a straight part
analysis.series.correlation.EVEN | 1 | slope | what is straight
analysis.series.embedding.LEAST | points | nothing | least points
analysis.series.embedding.FALSE_SHARE | 1 | neighbours | false ones that may be left
analysis.series.exponent.LEAST | points | nothing | least points
analysis.series.exponent.PERIODS | periods | nothing | least periods
analysis.series.exponent.BLOCKS | blocks | nothing | blocks that an error is taken from
analysis.series.exponent.MARGIN | 1 | logarithm of a distance | end of a straight part
analysis.series.exponent.LEAST_RISE | 1 | logarithm of a distance | least rise
analysis.series.exponent.FINITE | 1 | distances | those that are not small any more
analysis.series.exponent.FLOW | 1 | logarithm of a distance | a flow, not a map
analysis.series.kantz.REFERENCES | points | nothing | reference points
analysis.series.kantz.NEIGHBOURS | points | nothing | neighbours of each
analysis.series.rosenstein.REFERENCES | points | nothing | reference points
analysis.series.samples.LARGEST | 1 | nothing | largest sample whose square is a number
analysis.series.samples.ROUND_OFF | 1 | spacing | uneven spacing
analysis.series.spectrum.LOBE | bins | nothing | half-width of a line
analysis.series.spectrum.ABOVE_FLOOR | 1 | median | height of a line
analysis.series.spectrum.AROUND | bins | nothing | width of the median
analysis.series.spectrum.LINES | 1 | power | power in lines of what is periodic
analysis.series.spectrum.BROAD | 1 | power | the same of what is broad
analysis.series.wolf.CANDIDATES | points | nothing | neighbours that are looked at
analysis.series.wolf.BIAS | 1 | exponent | bias that is accepted
analysis.series.wolf.LASTING | 1 | neighbours | those that last
analysis.series.wolf.SMALLEST | 1 | spread | smallest distance
analysis.series.zero_one.ENOUGH | points | nothing | least points
analysis.series.zero_one.REGULAR | 1 | 0-1 test | regular below
analysis.series.zero_one.CHAOTIC | 1 | 0-1 test | chaotic above
program.symbolic.WIDEST | unknowns | nothing | widest supernode
program.symbolic.WASTE | 1 | entries | zeros that supernodes may hold
beams.mesh.SAME_PLACE | 1 | size of the mesh | nodes at one place
beams.mesh.STRAIGHT | rad | nothing | bend of a link that is straight
""")


def _left_out() -> dict[str, str]:
    """Why, by place."""
    reasons = """
    the default of an argument that is varied: contact.onset.LEAST_APPROACH
    a factor of a formula: analysis.exponent_error.LATE contact.friction.lugre.PASSIVE integrate.contact_work.GAUSS
        solve.project.TURN
        analysis.section_signals.TURN analysis.shooting.TURN beams.corotational.TURN beams.corotational.REST
    printed with the theory, and only a remark: contact.validity.LOVE contact.validity.YIELD_OF_POINT
        contact.validity.YIELD_OF_LINE
    start values of histories: contact.onset.HISTORY contact.validity.HISTORY_WITH_EXTREMES
    a name of a code, a mode or a place in an array: integrate.arrays.ENERGY_MISSING integrate.arrays.ENERGY_MADE
        integrate.arrays.ENERGY_LOST integrate.arrays.EPISODE integrate.arrays.EPISODE_ROW
        integrate.arrays.IMPACT integrate.arrays.CONTACT_MEMORY
        integrate.elastic_step.ELASTIC_SINGULAR integrate.elastic_step.TOO_FAR integrate.episodes.IMPACT
        integrate.episodes.CONTINUOUS
        integrate.netcdf.FORMAT
        integrate.newton.AGAIN
        integrate.run.NOT_SAVING integrate.tangent.LOST
        integrate.touch.IMPACT integrate.touch.LASTING
        integrate.remarks.APPROACH integrate.touch.CLOSING_PHASE integrate.touch.LASTING_PHASE
        solve.lu.HELD solve.lu.NO_ROW analysis.crossing.DOWN analysis.crossing.UP
        analysis.mechanism_flow.ONSET analysis.watched.LOST analysis.watched.UNDECIDED
        program.signals.CONTACT_PENETRATION program.tables.CONTACT_COMMON
    stands for infinity: integrate.arrays.NEVER
    a size of a buffer, a block or a store: integrate.arrays.PAST_STATES integrate.run.BUFFER
        integrate.run.BLOCK_SECONDS integrate.run.FIRST_BLOCK analysis.basin.CHUNKS analysis.series.neighbours.BLOCK
        analysis.series.recurrence.BLOCK program.smoke.REMEMBERED program.structure.KEPT
        program.structure.KEPT_UNKNOWNS program.structure.MANY integrate.run.BUFFER_NUMBERS integrate.run.LEAST_BUFFER
        integrate.saved.AHEAD
    how many are printed: integrate.episodes.SHOWN integrate.status.MOST solve.report.MOST integrate.chosen.OFFERED
    shortens what another number decides: solve.rank.SURELY
    coefficients and stages of Radau's method, exact: integrate.collocation.C integrate.collocation.ESTIMATE
        integrate.collocation.FROM_IM integrate.collocation.FROM_RE integrate.collocation.FROM_REAL
        integrate.collocation.LAST integrate.collocation.MIDDLE integrate.collocation.ONCE
        integrate.collocation.PAIR_IM integrate.collocation.PAIR_RE integrate.collocation.REAL
        integrate.collocation.STAGES integrate.collocation.TO_IM integrate.collocation.TO_RE
        integrate.collocation.TO_REAL integrate.collocation.TWICE integrate.collocation.WEIGHTS
        integrate.collocation._ROOT
    exact for what it integrates, or arbitrary instants: beams.fem.QUADRATURE_ORDER analysis.ode.INSTANTS
    """
    found, reason = {}, ""
    for word in reasons.split("\n"):
        head, colon, rest = word.partition(": ")
        reason = head.strip() if colon else reason
        found |= dict.fromkeys((rest if colon else head).split(), reason)
    return found


LEFT_OUT = _left_out()
"""Reason by place; names that are unpacked from a range are enumerations, and left out without being listed."""
