"""One map over the processes of an MPI run, each with a band of its rows."""

from roughcontact.contact.share import Slab as Slab, slab_rows as slab_rows
from roughcontact.formats.slab import read_slab as read_slab
