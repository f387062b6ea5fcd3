"""Public names of `flexmb.friction`: friction laws."""

from flexmb.parts.contact.friction import BengisuAkay as BengisuAkay
from flexmb.parts.contact.friction import BrownMcPhee as BrownMcPhee
from flexmb.parts.contact.friction import Frictionless as Frictionless
from flexmb.parts.contact.friction import LuGre as LuGre
from flexmb.parts.contact.friction import ModifiedCoulomb as ModifiedCoulomb
from flexmb.parts.contact.friction import SmoothCoulomb as SmoothCoulomb
from flexmb.parts.contact.friction import Stribeck as Stribeck
from flexmb.parts.contact.friction import Threlfall as Threlfall
