"""The independent reference: written from the specification alone, slow and plain; shares no code
with the product."""
