"""Bodies: rigid ones are one node at the centre of mass, flexible ones chains of nodes with beam elements."""
