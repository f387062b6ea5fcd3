"""Public names of `flexmb.controllers`: controllers and motors."""

from flexmb.parts.controllers.control import PID as PID
from flexmb.parts.controllers.control import Control as Control
from flexmb.parts.controllers.control import DCMotor as DCMotor
