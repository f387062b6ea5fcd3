"""Public names of `flexmb.controllers`: controllers and motors."""

from flexmb.controllers.control import Control as Control
from flexmb.controllers.dc_motor import DCMotor as DCMotor
from flexmb.controllers.pid import PID as PID
