"""Public names of `flexmb.friction`: friction laws."""

from flexmb.contact.friction.bengisu_akay import BengisuAkay as BengisuAkay
from flexmb.contact.friction.brown_mcphee import BrownMcPhee as BrownMcPhee
from flexmb.contact.friction.frictionless import Frictionless as Frictionless
from flexmb.contact.friction.lugre import LuGre as LuGre
from flexmb.contact.friction.modified_coulomb import ModifiedCoulomb as ModifiedCoulomb
from flexmb.contact.friction.smooth_coulomb import SmoothCoulomb as SmoothCoulomb
from flexmb.contact.friction.stribeck import Stribeck as Stribeck
from flexmb.contact.friction.threlfall import Threlfall as Threlfall
