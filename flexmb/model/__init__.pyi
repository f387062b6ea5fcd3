"""Public names of `flexmb.model`: records by which a part of one's own describes itself."""

from flexmb.fields import field as field
from flexmb.fields import not_negative as not_negative
from flexmb.fields import positive as positive
from flexmb.fields import record as record
from flexmb.model.contributions import Attachment as Attachment
from flexmb.model.contributions import ConstraintContribution as ConstraintContribution
from flexmb.model.contributions import ContactContribution as ContactContribution
from flexmb.model.contributions import Reaction as Reaction
from flexmb.model.contributions import SignalContribution as SignalContribution
