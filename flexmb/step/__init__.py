"""Motion in time: methods, step control, the compiled loop, and the record of a run.

Where things stand:

    predictor                 newmark/predictor.py: predict, weights;  radau/step.py: begin
    residual, Newton, matrix  newmark/implicit_step.py (its docstring has the equations);  radau/step.py: radau_step
    estimate of the error     newmark/error_control.py: error_ratio;  radau/step.py: radau_error
    onset of contacts         contact_events.py: planned foresees, located corrects a trial, remember learns from a step
    acceptance of a step      acceptance.py: find_forces, book, take_over, publish
    account of energies       energy/balance.py
    a new method              method.py, stepper.py; "Methods" in docs/design.md

A pass of a loop with error control, and who writes what between the parts (`Clock`, `Counters` in the room `state`):

    planned   the step to try: the least of clock.size (errors), clock.brake (within an impact), clock.again (after a
              contact had a trial refused)
    the step  trial.q, v, a, lam; count.outcome (held rows), count.known (what is known of the trial state)
    met       a trial that did not converge shortens size or brake; one that met a contact badly sets again
    judged    clock.speed, or clock.refused; 0 stands for a trial that is refused
    remember  flow.impacts, the step of each contact's impact, while `flow` still is the state before the step
    resize    clock.size or brake for the next step; clears again and refused
    accept    flow, ledger, signals, clock.t; the loop sets clock.last: 0 where the next step begins anew
"""
