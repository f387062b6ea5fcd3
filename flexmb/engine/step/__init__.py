"""Steps: methods, step control, contact events, acceptance of a step.

A step of the Newmark family (`take_steps` of `engine/newmark/method.py`), with the function and the file of each part:

    planned_step             step/contact_events.py         step to try: clock.step_size, clock.contact_step within an
      |                                                     impact, clock.retry_step after a missed contact event; not
      |                                                     beyond the next onset
    implicit_step            newmark/implicit_step.py       discrete equations, in its docstring
      |  predict             newmark/predictor.py           extrapolated accelerations and multipliers
      |  project_prediction  newmark/predictor.py           predicted positions on the constraints
      |  may_reuse           newmark/jacobian_reuse.py      factors of an earlier iteration matrix, or new ones
      |  evaluate            system/evaluate.py             residual r + G^T lam, constraints, iteration matrix
      |  factor, solve       linalg/lu.py                   factors of [[S, G^T], [G, 0]], corrections
      |  held_rows_open      newmark/implicit_step.py       redundant constraints; gaps of held rows: jacobian_reuse.py
      |  apply_correction    newmark/implicit_step.py       corrected trial state, size of the correction
      |  convergence_test    newmark/jacobian_reuse.py      contraction rate, remaining error
    meets_contacts           newmark/error_control.py       no: shorter trial at the event (step/contact_events.py)
    error_ratio              newmark/error_control.py       estimate of the local error
    accept_or_reject         newmark/error_control.py       rejected: shorter trial
      |  accepted
    adopt_factors            newmark/jacobian_reuse.py      factors and contraction rate for the next step
    update_impacts           step/contact_events.py         flow.impacts; whether a force jumped
    update_step_sizes        newmark/error_control.py       clock.step_size or clock.contact_step of the next step
    update_predictor         newmark/predictor.py           order of the next prediction
    accept                   step/acceptance.py
         complete_evaluation step/acceptance.py             forces and energies that the last iteration left out
         update_energies     step/acceptance.py             joint forces, step/contact_events.py, engine/energy.py
         adopt_trial         step/acceptance.py             the trial state becomes the accepted state
         update_peaks        step/acceptance.py             largest values of all signals
         save_instants       step/acceptance.py         rows of the save grid

The parts communicate by the fields of `Clock`, `Counters`, `StepReport` and `NewtonIteration` in the room `state`.

Radau's method (`radau/method.py`, `radau/step.py`) and the Runge-Kutta method (`runge_kutta.py`) share step control,
contact events and acceptance.  A new method is a `Method` and a `Stepper` (`step/method.py`).
"""
