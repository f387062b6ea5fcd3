"""Steps: methods, step control, contact events, acceptance of a step.

A step of the Newmark family (`newmark/loop.py`), with the function and the file of each part:

    planned_step             contact_events.py              step to try: clock.step_size, clock.contact_step within an
      |                                                     impact, clock.retry_step after a missed contact event; not
      |                                                     beyond the next onset
    implicit_step            newmark/implicit_step.py       discrete equations, in its docstring
      |  predict             newmark/predictor.py           extrapolated accelerations and multipliers
      |  may_reuse           newmark/jacobian_reuse.py      factors of an earlier iteration matrix, or new ones
      |  evaluate            engine/system/evaluate.py             residual r + G^T lam, constraints, iteration matrix
      |  factor, solve       engine/linalg/lu.py                   factors of [[S, G^T], [G, 0]], corrections
      |  held_rows_open      newmark/implicit_step.py       redundant constraints in newmark/redundant_constraints.py
      |  apply_correction    newmark/newton_correction.py   corrected trial state, size of the correction
      |  convergence_test    newmark/jacobian_reuse.py      contraction rate, remaining error
    meets_contacts           newmark/error_control.py       no: shorter trial at the event (contact_events.py)
    error_ratio              newmark/error_control.py       estimate of the local error
    accept_or_reject         newmark/error_control.py       rejected: shorter trial
      |  accepted
    adopt_factors            newmark/jacobian_reuse.py      factors and contraction rate for the next step
    update_impacts           contact_events.py              flow.impacts; whether a force jumped
    update_step_sizes        newmark/error_control.py       clock.step_size or clock.contact_step of the next step
    update_predictor         newmark/predictor.py           order of the next prediction
    accept                   acceptance.py
         complete_evaluation acceptance.py                  forces and energies that the last iteration left out
         update_energies     acceptance.py                  joint forces, contact_log.py, engine/energy.py
         adopt_trial         acceptance.py                  the trial state becomes the accepted state
         update_peaks        acceptance.py                  largest values of all signals
         save_instants       saved_instants.py              rows of the save grid

The parts communicate by the fields of `Clock`, `Counters`, `StepReport` and `NewtonIteration` in the room `state`.

Radau's method (`radau/method.py`, `radau/step.py`) and the Runge-Kutta method (`runge_kutta.py`) share step control,
contact events and acceptance.  A new method is a `Method` (`method.py`) and a `Stepper` (`stepper.py`).
"""
